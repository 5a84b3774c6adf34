"""Sums up the results of all benchmarks for README.md: how much faster ours is than what it was measured beside,
where it is slower, and how many answers of each library of single pairs were wrong.
"""

import statistics

import motion_table
import narrowphase_table
from scene_table import OURS, by_row
from sweep_table import best_fcl


def pairs_of_shapes(results):
    for name, _, ratio in narrowphase_table.compared(results["narrowphase"]["rows"]):
        if ratio:
            yield name, ratio


def beside_fcl(entries, key="median_us"):
    """Yields each row with the time of the fastest of FCL's ways over ours."""
    for row, libraries in by_row(entries).items():
        yield row, best_fcl(libraries, key)[key] / libraries[OURS][key]


def beside(entries, other, key="ns"):
    """Yields each row with the time of another library over ours."""
    for row, libraries in by_row(entries).items():
        yield row, libraries[other][key] / libraries[OURS][key]


def constraint_rows(results):
    for entry in results["scene"]["constraint_rows"]:
        yield f"{entry['row']}, within {entry['influence_distance']:g} m", entry["fcl_us"] / entry["median_us"]


def contacts_beside_fcl(results):
    for row, entries in motion_table.by_row(results["motion"]["rows"]).items():
        yield row, motion_table.fcl_advancement(entries)["ns"] / entries[OURS]["ns"]


def simplices(results):
    entries = results["subalgorithms"]["subalgorithms"]
    for kind in dict.fromkeys(entry["simplices"] for entry in entries):
        ns = {entry["algorithm"]: entry["ns"] for entry in entries if entry["simplices"] == kind}
        ours = ns.pop("voronoi regions")
        yield kind, min(ns.values()) / ours


def services(results):
    for row in results["node"]["services"]:
        name = f"{row['service']}, {row['clients']} clients, {row['connection']}"
        yield name, row["empty"]["median_us"] / row["ours"]["median_us"]


def contests(results):
    """Yields what was measured, beside what, and each row's name with the time of the other over ours."""
    scene, sweep, motion = (results[name] for name in ("scene", "sweep", "motion"))
    yield "two shapes", "the fastest without a wrong answer", pairs_of_shapes(results)
    yield "nearest point of a simplex", "the fastest other algorithm", simplices(results)
    yield "a robot, state by state", "the fastest way of FCL", beside_fcl(scene["rows"])
    yield "a robot among objects", "the fastest way of FCL", beside_fcl(scene["cells"])
    yield "2 to 500 bodies", "the fastest way of FCL", beside_fcl(scene["scaling"])
    yield "constraint rows", "the same formula with FCL", constraint_rows(results)
    yield "sweeps", "the fastest way of FCL", beside_fcl(sweep["rows"], "ns")
    yield "sweeps", "spheres, which are inexact", beside(sweep["rows"], "spheres")
    yield "time of contact", "FCL's advancement", contacts_beside_fcl(results)
    yield "time of contact", "swept bisection", beside(motion["rows"], "swept bisection")
    yield "robots in motion", "samples at 1 kHz", beside(motion["robots"], "sampling, 1 kHz", "median_us")
    yield "a call of a service", "an empty service", services(results)


def times(results):
    for what, other, ratios in contests(results):
        by_name = dict(ratios)
        worst = min(by_name, key=by_name.get)
        slower = sum(ratio < 1.0 for ratio in by_name.values())
        yield [what, other, f"{statistics.median(by_name.values()):.1f}", f"{max(by_name.values()):.1f}",
               f"{slower} of {len(by_name)}", f"{by_name[worst]:.2f}: {worst}"]


def wrong_answers(entries):
    for library in dict.fromkeys(entry["library"] for entry in entries):
        own = [entry for entry in entries if entry["library"] == library]
        yield [library, f"{sum(entry['checked'] for entry in own):,}", f"{sum(entry['failures'] for entry in own):,}",
               f"{max(entry['max_error'] for entry in own):.0e}"]


def tables(results):
    """Returns the head and the lines of each table by its name."""
    return {
        "times": (["measured", "beside", "median of other / ours", "most", "ours slower in rows", "worst row"],
                  times(results)),
        "errors": (["two shapes", "checked answers", "wrong by over 1 mm, or missing", "largest error [m]"],
                   wrong_answers(results["narrowphase"]["rows"])),
    }
