"""Shows the result file of ./dev bench meshes as a table: what stands for each mesh, and how far pieces and mesh lie from each
other.

usage: meshes_table.py RESULT.json
"""

from table import show_result


def meshes(entries):
    for entry in entries:
        ratio = entry["volume_ratio"]
        yield [entry["robot"], entry["link"], entry["representation"], str(entry["pieces"]), str(entry["vertices"]),
               f"{1e3 * entry['deviation']:.2f} mm", f"{1e3 * entry['uncovered']:.2f} mm",
               "open" if ratio is None else f"{ratio:.3f}"]


def tables(result):
    """By name the head and the lines of each table that README.md shows."""
    return {"meshes": (["robot", "link", "representation", "pieces", "vertices", "outside of the mesh", "not covered",
                        "hull / mesh volume"], meshes(result["meshes"]))}


def facts(result):
    """By name what README.md says in its text."""
    return {"tolerance_mm": f"{1e3 * result['tolerance']:g}"}


if __name__ == "__main__":
    show_result(tables)
