"""Makes tables of a result file of motion_benchmark: time of contact of two solids beside FCL and sampling, what a
tighter setting costs, the smallest distance of a motion, and robots along joint motions.
"""

OURS = "ours"


def by_row(entries):
    """Returns the entries of each row by library and setting."""
    rows = {}
    for entry in entries:
        rows.setdefault(entry["row"], {})[label(entry)] = entry
    return rows


def label(entry):
    """Returns the name of a library, with the number of samples if it takes some."""
    name = entry["library"]
    return f"{name} {entry['setting']:.0f}" if entry["setting"] >= 1 else name


def time(ns):
    """Returns a time with three digits and its unit."""
    for unit, size in (("s", 1e9), ("ms", 1e6), ("us", 1e3)):
        if ns >= size:
            return f"{ns / size:.3g} {unit}"
    return f"{ns:.3g} ns"


def wrong(entry):
    """Returns how often a library is wrong in which way, and how often it says nothing."""
    names = (("missed", "missed"), ("late", "late"), ("false", "false"), ("undecided", "undecided"), ("unanswered", "no answer"))
    return ", ".join(f"{entry[key]} {name}" for key, name in names if entry.get(key))


def cell(entry):
    """Returns the median time / the largest error as a distance, and what is wrong."""
    if entry is None or "ns" not in entry:
        return "-"
    error = f" / {entry['max_error']:.0e}" if entry["contacts"] else ""
    faults = wrong(entry)
    return f"{time(entry['ns'])}{error}" + (f" !{faults}" if faults else "")


def fcl_advancement(entries):
    """Returns the entry of FCL's conservative advancement, by the solver that is faster, or None if it was not asked."""
    return min((e for name, e in entries.items() if name.startswith("FCL advancement") and "ns" in e), key=lambda e: e["ns"],
               default=None)


def ratio(entries):
    """Returns FCL's conservative advancement over ours: the time, and the error if there are contacts."""
    ours, fcl = entries[OURS], fcl_advancement(entries)
    if not fcl:
        return "-"
    errors = f" / {fcl['max_error'] / ours['max_error']:.0e}" if ours["contacts"] and ours["max_error"] else ""
    return f"{fcl['ns'] / ours['ns']:.1f}{errors}"


def contacts(rows, names):
    for row, entries in rows.items():
        dense = next((e for e in entries.values() if "ns_for_tolerance" in e), None)
        extrapolated = f"{dense['samples_for_tolerance']:.0e}: {time(dense['ns_for_tolerance'])}" if dense else "-"
        yield [row, *(cell(entries.get(name)) for name in names), extrapolated, ratio(entries),
               f"{entries[OURS]['queries']:.1f}"]


def in_full(entries):
    """Yields every entry in full."""
    for entry in entries:
        if "ns" not in entry:
            continue
        yield [entry["row"], label(entry), time(entry["ns"]), time(entry["p99_ns"]), f"{entry['max_time_error']:.0e}",
               f"{entry['mean_time_error']:.0e}", f"{entry['max_error']:.0e}", f"{entry['mean_error']:.0e}",
               f"{entry['missed']} / {entry['late']} / {entry['false']}", f"{entry['contacts']} of {entry['motions']}"]


def tuned(entries):
    """Yields a line for each library and setting of each row."""
    for entry in entries:
        if "ns" in entry:
            yield [entry["row"], entry["library"], f"{entry['setting']:g}", time(entry["ns"]),
                   f"{entry['max_error']:.0e}", f"{entry['mean_error']:.0e}", wrong(entry) or "-"]


def smallest(rows):
    """Yields ours at each of its tolerances, beside the fewest samples that are as exact."""
    for row, entries in rows.items():
        ours = [e for e in entries if e["library"] == OURS and "ns" in e]
        sampling = sorted((e for e in entries if e["library"] == "sampling" and "ns" in e), key=lambda e: e["setting"])
        for entry in ours:
            enough = next((e for e in sampling if e["max_error"] <= max(entry["max_error"], entry["setting"])), None)
            beside = f"{enough['setting']:.0f}: {time(enough['ns'])}" if enough else (
                f"more than {sampling[-1]['setting']:.0f}: {time(sampling[-1]['ns'])}, {sampling[-1]['max_error']:.0e}"
                if sampling else "-")
            yield [row, f"{entry['setting']:g}", f"{time(entry['ns'])} / {time(entry['p99_ns'])}",
                   f"{entry['max_error']:.0e}", f"{entry['queries']:.1f}", beside,
                   str(entry["unproven"])]


def robot_time(entry):
    return f"{time(1e3 * entry['median_us'])} / {time(1e3 * entry['p99_us'])}" if "p99_us" in entry else (
        f"{entry['samples']:.0e}: {time(1e3 * entry['median_us'])}")


def robots(entries):
    rows = {}
    for entry in entries:
        rows.setdefault(entry["row"], {})[entry["library"]] = entry
    for row, libraries in rows.items():
        ours, sampled, fine = (libraries.get(name) for name in (OURS, "sampling, 1 kHz", "sampling, our guarantee"))
        counts = ours["counts"]
        seen = (f"{sampled['missed']} of {sampled['contacts']}, {1e3 * sampled['max_late']:.2f} ms"
                if "missed" in sampled else f"{1e3 * sampled['max_error']:.1e} mm")
        yield [row, robot_time(ours), robot_time(sampled), robot_time(fine) if fine else "-", seen,
               f"{sampled['contradicted']} / {ours['unconfirmed']}",
               *(f"{counts[key]:.1f}" for key in ("pairs", "by_one_bound", "intervals", "queries"))]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    rows = by_row(result["rows"])
    found = {}
    if rows:
        names = list(dict.fromkeys(label(entry) for entry in result["rows"]))
        found["contact"] = (["time / largest error [m]", *names, "samples for 1e-9 m", "FCL advancement / ours",
                             "our queries"], contacts(rows, names))
    if result["minimum"]:
        groups = {}
        for entry in result["minimum"]:
            groups.setdefault(entry["row"], []).append(entry)
        found["minimum"] = (["smallest distance", "tolerance [m]", "ours, median / 99 %", "largest error [m]", "queries",
                             "samples with that error", "unproven"], smallest(groups))
    if result["robots"]:
        found["robots"] = (["joint motion of 1 s or spline, median / 99 %", "ours", "1 kHz", "samples at our guarantee",
                            "1 kHz misses", "contradicted / unconfirmed", "pairs", "by one bound", "intervals", "queries"],
                           robots(result["robots"]))
    return found


def details(result):
    """Returns the head and the lines of each table that only the terminal shows."""
    found = []
    if result["rows"]:
        found.append((["time of contact", "library", "median", "99 %", "largest error", "mean", "largest [m]", "mean [m]",
                       "missed / late / false", "contacts"], in_full(result["rows"])))
        found.append((["setting", "library", "", "median", "largest error [m]", "mean [m]", "wrong"], tuned(result["tolerances"])))
    return found


def note(_):
    return ("!: contacts missed, found after the true one, or claimed where there is none. Samples for 1e-9 m, and at our\n"
            "guarantee: in such steps that nothing comes closer in between than by our tolerance; their time is extrapolated. 1 kHz\n"
            "misses: contacts, and its largest delay or error. Contradicted: by a sample; unconfirmed: by the state at our time.")
