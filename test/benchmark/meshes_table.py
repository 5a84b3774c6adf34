"""Makes a table of the result file of ./dev bench meshes: what stands for each mesh, and how far pieces and mesh lie
from each other.
"""


def meshes(entries):
    for entry in entries:
        ratio = entry["volume_ratio"]
        yield [entry["robot"], entry["link"], entry["representation"], str(entry["pieces"]), str(entry["vertices"]),
               f"{1e3 * entry['deviation']:.2f} mm", f"{1e3 * entry['uncovered']:.2f} mm",
               "open" if ratio is None else f"{ratio:.3f}"]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    return {"meshes": (["robot", "link", "representation", "pieces", "vertices", "outside of the mesh", "not covered",
                        "hull / mesh volume"], meshes(result["meshes"]))}


def facts(result):
    """Returns what TABLES.md says in its text by name."""
    return {"tolerance_mm": f"{1e3 * result['tolerance']:g}"}
