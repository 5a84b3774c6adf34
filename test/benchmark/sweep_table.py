"""Makes tables of a result file of sweep_benchmark: nanoseconds a state and states a second, how far the answers of
the others lie from ours, the efficiency of two threads, and what a batch costs.
"""

from scene_table import best_fcl, by_row

OURS, SCENE, WITHIN, SPHERES = "ours", "ours, Scene", "ours, 0.1 mm", "spheres"
VERDICT = "any below 5 cm"


def nanoseconds(value):
    return f"{value:,.0f}" if value >= 100 else f"{value:.1f}"


def rate(ns):
    """Returns how many states a second one core answers, with a unit."""
    per_second = 1e9 / ns
    for unit, size in (("M", 1e6), ("k", 1e3)):
        if per_second >= size:
            return f"{per_second / size:.3g}{unit}"
    return f"{per_second:.0f}"


def times(rows):
    for row, libraries in rows.items():
        ours, fcl = libraries[OURS], best_fcl(libraries, "ns")
        yield [row, nanoseconds(ours["ns"]), rate(ours["ns"]), nanoseconds(libraries[SCENE]["ns"]),
               f"{nanoseconds(fcl['ns'])} ({fcl['library'].replace('FCL ', '')})", nanoseconds(libraries[SPHERES]["ns"]),
               f"{fcl['ns'] / ours['ns']:.1f}", f"{libraries[SPHERES]['ns'] / ours['ns']:.2f}"]


def within(rows):
    """Yields the rows of the minimum within an accuracy, beside the exact one and spheres."""
    for row, libraries in rows.items():
        if WITHIN in libraries:
            bounds, exact, others = (libraries[name]["ns"] for name in (WITHIN, OURS, SPHERES))
            yield [row, nanoseconds(bounds), rate(bounds), f"{exact / bounds:.2f}", f"{others / bounds:.2f}"]


def spheres(result):
    """Yields for each robot the wrong verdicts about 5 cm, and the largest errors of the minimum."""
    counts = {batch["robot"]: batch["spheres"] for batch in result["batches"]}
    entries = [entry for entry in result["rows"] if entry["library"] == SPHERES]
    for robot in dict.fromkeys(entry["robot"] for entry in entries):
        of_robot = [entry for entry in entries if entry["robot"] == robot]
        verdicts = [entry["agreement"] for entry in of_robot if entry["question"] == VERDICT]
        minima = [entry["agreement"] for entry in of_robot if entry["question"] == "minimum"]
        states = sum(agreement["states"] for agreement in verdicts)
        below, claimed, missed = (sum(agreement[key] for agreement in verdicts)
                                  for key in ("below", "below_claimed", "below_missed"))
        worst = [max((agreement[key] for agreement in minima), default=0.0) for key in ("too_near", "too_far")]
        yield [robot, str(counts.get(robot, "-")), f"{states:,}", share(below, states), share(claimed, states), share(missed, states),
               *(f"{1e3 * error:.0f} mm" for error in worst),
               str(sum(agreement["overlaps_claimed"] for agreement in minima))]


def share(count, of):
    return f"{count:,} ({count / of:.2%})" if of else "-"


def agreement(result):
    """Yields a line for each robot and library, our Scene and FCL, over all rows of the robot."""
    groups = {}
    for entry in result["rows"]:
        if entry["library"] not in (OURS, WITHIN, SPHERES):
            groups.setdefault((entry["robot"], entry["library"]), []).append(entry["agreement"])
    for (robot, library), found in groups.items():
        def total(key, parts=found):
            return sum(part.get(key, 0) for part in parts)

        judged = [part["judged"] for part in found if "judged" in part]
        verdict = " / ".join(str(total(key, judged)) for key in ("ours_right", "other_right")) + f" of {total('judged', judged)}"
        yield [robot, library, f"{total('compared'):,}", f"{max(max(p.get('too_near', 0), p.get('too_far', 0)) for p in found):.0e}",
               str(total("differing")), verdict if judged else "-",
               f"{total('overlaps_missed')} / {total('overlaps_claimed')}",
               f"{total('below_missed')} / {total('below_claimed')}"]


def threads(entries):
    for entry in entries:
        yield [f"{entry['robot']}, {entry['question']}", rate(1e9 / entry["states_per_second"]), f"{entry['efficiency']:.0%}"]


def batches(entries):
    for entry in entries:
        yield [entry["robot"], str(entry["links"]), str(entry["pieces"]), f"{1e3 * entry['seconds']:.1f} ms",
               f"{entry['bytes'] / 1024:,.0f} KiB"]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    return {
        "times": (["ns a state", "ours", "states a second", "Scene alone", "best FCL", "spheres", "FCL / ours", "spheres / ours"],
                  times(by_row(result["rows"]))),
        "within": (["bounds within 0.1 mm, ns a state", "ours", "states a second", "exact / this", "spheres / this"],
                   within(by_row(result["rows"]))),
        "spheres": (["what spheres say", "spheres", "states", "proven below 5 cm", "below 5 cm, proven above", "above 5 cm, proven below",
                     "too near by at most", "too far by at most", "overlaps claimed"], spheres(result)),
        "agreement": (["beside ours", "library", "compared", "largest difference [m]", "differing", "right: ours / other",
                       "overlaps missed / claimed", "below 5 cm missed / claimed"], agreement(result)),
        "threads": (["two threads on two cores", "states a second of one", "efficiency"], threads(result["threads"])),
        "batches": (["a SceneBatch of", "links", "pieces", "made in", "memory"], batches(result["batches"])),
    }


def note(result):
    return (f"batches of {result['batch']} states; {result['processor']}, {result['instruction_set']}; differing: by more than 1e-6 m; "
            "right:\nthe first 20 of a row, by the oracle of the tests")
