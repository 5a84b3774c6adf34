"""Makes tables of a result file of points_benchmark: points around a Panda beside FCL and a kd-tree of vertices, and rays."""

OTHERS = ("FCL", "kd-tree")


def millimetres(length):
    return f"{1e3 * length:.2g}"


def clouds(entries):
    for entry in entries:
        libraries = {library["library"]: library for library in entry["libraries"]}
        ours = libraries["ours"]["us"]
        line = [entry["row"], f"{100 * entry['near']:.1f} %", f"{100 * entry['computed']:.1f} %", f"{ours:.2f}"]
        for name in OTHERS:
            if name not in libraries:
                line += ["", "", ""]
                continue
            other = libraries[name]
            line += [f"{other['us']:.2f}", f"{other['us'] / ours:.1f}",
                     f"{millimetres(other['differences']['median'])} / {millimetres(other['differences']['most'])}"]
        yield line


def rays(entries):
    for entry in entries:
        yield [entry["row"], f"{100 * entry['hits']:.1f} %", f"{entry['us']:.2f}"]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    others = [head for name in OTHERS for head in (f"{name} [us]", "/ ours", "off [mm]: median / most")]
    return {
        "clouds": (["points", "within 0.1 m", "computed", "ours [us]", *others], clouds(result["clouds"])),
        "rays": (["rays", "hits", "ours [us]"], rays(result["rays"])),
    }


def note(result):
    return (f"microseconds of a point or ray, the median of {result['rounds']} rounds; the others have one point in {result['others']}; "
            f"off: from our distance,\nof points outside and within the threshold; processor time; {result['processor']}")
