"""Makes tables of a result file of sensed_benchmark: what a depth camera sees, beside FCL with an octree and with boxes."""


def time(milliseconds):
    return f"{milliseconds:.3g}"


def millimetres(length):
    return f"{1e3 * length:.2g}"


def steps(rows):
    for row in rows:
        counts = [f"{row[key]:,}" for key in ("points", "on robot", "voxels", "boxes")]
        yield [row["row"], *counts, *(time(step["ms"]) for step in row["steps"])]


def minima(rows):
    for row in rows:
        ours = {step["step"]: step["ms"] for step in row["steps"]}
        yield [row["row"], "ours", time(ours["object"] + ours["set"]), time(ours["next minimum"]), "",
               f"{1e3 * row['minimum']:.1f} / {1e3 * row['nearest point']:.1f}", millimetres(row["error"]), ""]
        for peer in row["peers"]:
            update, minimum = (step["ms"] for step in peer["steps"])
            yield [row["row"], peer["library"], time(update), time(minimum), f"{minimum / ours['next minimum']:.1f}", "",
                   millimetres(peer["error"]), str(peer["failures"])]


def tables(result):
    """Returns the head and the lines of each table by its name."""
    rows = result["rows"]
    names = [step["step"] for step in rows[0]["steps"]] if rows else []
    return {
        "steps": (["robot, voxels", "points", "on robot", "voxels", "boxes", *(f"{name} [ms]" for name in names)], steps(rows)),
        "minima": (["robot, voxels", "library", "update [ms]", "minimum [ms]", "/ ours", "voxel / nearest point [mm]", "off [mm]",
                    "failures"], minima(rows)),
    }


def note(result):
    return (f"milliseconds of the processor, the median of {result['rounds']} rounds; next minimum: of a robot that moved, with its "
            f"kinematics;\noff: the most from the distance of all voxels, one by one; {result['processor']}")
