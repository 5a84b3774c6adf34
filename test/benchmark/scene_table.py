"""Makes tables of a result file of scene_benchmark: microseconds a state, how the pairs were settled, how far FCL's
distances lie from ours, and time against the number of bodies.
"""

OURS = "ours"
RUNGS = ["unknown", "at_rest", "by_motion", "by_bounds", "computed"]


def by_row(entries):
    """Returns the entries of each row by library."""
    rows = {}
    for entry in entries:
        rows.setdefault(entry["row"], {})[entry["library"]] = entry
    return rows


def number(value):
    return f"{value:.1f}" if value < 100 else f"{value:.0f}"


def time(entry):
    return f"{number(entry['median_us'])} / {number(entry['p99_us'])}" if entry else "-"


def best_fcl(libraries, key):
    """Returns the entry of the fastest of FCL's ways, or None if FCL was not asked."""
    return min((entry for name, entry in libraries.items() if name.startswith("FCL")), key=lambda entry: entry[key],
               default=None)


def fcl_over_ours(libraries):
    """Returns the median of the fastest of FCL's ways over that of ours, or None if FCL was not asked."""
    fcl = best_fcl(libraries, "median_us")
    return fcl["median_us"] / libraries[OURS]["median_us"] if fcl else None


def best_other(libraries):
    ratio = fcl_over_ours(libraries)
    return f"{ratio:.1f}" if ratio else "-"


def times(rows, names):
    for row, libraries in rows.items():
        yield [row, *(time(libraries.get(name)) for name in names), best_other(libraries),
               f"{libraries[OURS]['overlapping']:.0%}"]


def rungs(rows):
    for row, libraries in rows.items():
        entry = libraries[OURS]
        yield [row, str(entry["pairs"]), *(f"{entry['counts'][rung]:.2f}" for rung in RUNGS), f"{entry['skipped']:.1%}"]


def errors(entries):
    """Yields a line for each robot and library, over all rows of the robot."""
    groups = {}
    for entry in entries:
        if "agreement" in entry:
            groups.setdefault((entry["robot"], entry["library"]), []).append(entry)
    for (robot, library), group in groups.items():
        all_of = [entry["agreement"] for entry in group]

        def total(key):
            return sum(agreement[key] for agreement in all_of)

        largest = [max((a[key] for a in all_of if key in a), default=0.0) for key in ("p99_error", "max_error")]
        yield [robot, library, f"{total('compared'):,}", *(f"{error:.0e}" for error in largest),
               str(total("differing")), f"{total('ours_right')} / {total('other_right')} of {total('judged')}",
               f"{total('overlaps_missed')} / {total('overlaps_claimed')}",
               str(total("unanswered") + sum(entry["failures"] for entry in group))]


def scaling(rows, names):
    for row, libraries in rows.items():
        entry = libraries[OURS]
        yield [row, str(entry["pairs"]), number(entry["pairs_in_reach"]), number(entry["counts"]["computed"]),
               *(time(libraries.get(name)) for name in names)]


def cells(rows, names):
    for row, libraries in rows.items():
        entry = libraries[OURS]
        yield [row, f"{entry['pairs']:,}", f"{entry['counts']['computed']:.2f}", *(time(libraries.get(name)) for name in names),
               best_other(libraries), f"{entry['overlapping']:.0%}"]


def added(entries):
    for entry in entries:
        yield [entry["row"], *(number(entry[key]) for key in ("median_us", "p99_us", "most_us"))]


def constraint_rows(entries):
    for entry in entries:
        yield [entry["row"], f"{entry['influence_distance']:g} m", f"{entry['rows_used']:.1f} of {entry['rows']}",
               f"{number(entry['distances_us'])} / {number(entry['distances_p99_us'])}", time(entry),
               f"{number(entry['fcl_us'])} / {number(entry['fcl_p99_us'])}", f"{entry['fcl_us'] / entry['median_us']:.1f}",
               f"{entry['gradient_us']:.2f}" if "gradient_us" in entry else "-"]


def guaranteed(entries):
    for entry in entries:
        yield [entry["row"].replace(", guaranteed", ""), f"{entry['uncertainty']:g}", number(entry["distances_us"]), time(entry),
               f"{entry['ratio']:.2f}", f"{1e3 * entry['median_loss']:.2g} / {1e3 * entry['p99_loss']:.2g}"]


def facts(result):
    ratios = {row: fcl_over_ours(libraries) for row, libraries in by_row(result.get("cells", [])).items()}
    slower = [f"{row} ({ratio:.2f})" for row, ratio in ratios.items() if ratio and ratio < 1.0]
    return {"slower_among_objects": "; ".join(slower) or "none"}


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    rows, arms = by_row(result["rows"]), by_row(result["scaling"])
    found = {}
    if rows:
        names = list(dict.fromkeys(entry["library"] for entry in result["rows"]))
        found["times"] = (["us a state, median / 99 %", *names, "best FCL / ours", "states in overlap"], times(rows, names))
        found["rungs"] = (["pairs of ours, mean", "pairs", *(rung.replace("_", " ") for rung in RUNGS), "skipped"], rungs(rows))
        found["errors"] = (["distance apart [m]", "beside ours", "compared", "99 %", "largest", "differing",
                            "right: ours / other", "overlaps missed / claimed", "no answer"], errors(result["rows"]))
    of_cells = result.get("cells", [])
    names = list(dict.fromkeys(entry["library"] for entry in of_cells))
    found["cells"] = (["us a state, median / 99 %", "pairs", "computed", *names, "best FCL / ours", "states in overlap"],
                      cells(by_row(of_cells), names))
    found["added"] = (["a box is added to 1000 objects, us", "median", "99 %", "most"], added(result.get("added", [])))
    found["constraint_rows"] = (["us a state, median / 99 %", "within", "rows used, mean", "distances alone", "constraint rows",
                                 "rows by FCL hulls", "FCL / ours", "gradient of a pair, us"],
                                constraint_rows(result.get("constraint_rows", [])))
    found["guaranteed"] = (["us a state, median / 99 %", "uncertainty of a joint, rad or m", "distances alone", "with the guaranteed one",
                            "ratio", "below the distance by, mm"], guaranteed(result.get("guaranteed", [])))
    if arms:
        names = list(dict.fromkeys(entry["library"] for entry in result["scaling"]))
        found["scaling"] = (["arms side by side", "pairs", "boxes in reach", "computed", *names], scaling(arms, names))
    return found


def note(_):
    return ("99 %, largest: of the differences, the worst row; differing: by more than 1e-6; right: the first 20 of them\n"
            "in each row, by the oracle of the tests; claimed: overlaps of pairs that are apart. FCL gives no depths.")
