"""Makes tables of a result file of narrowphase_benchmark: median nanoseconds a query / largest error, a column a
library; and median nanoseconds of ours, a column a question.
"""

COLUMNS = [  # the better of those that share a column
    ("ours", ["ours"]),
    ("FCL libccd", ["FCL libccd"]),
    ("FCL INDEP", ["FCL INDEP"]),
    ("libccd", ["libccd"]),
    ("Bullet", ["Bullet GJK", "Bullet EPA2"]),
]


def better(entries):
    """Returns the entry with fewer gross errors, or the faster of two with as many."""
    return min(entries, key=lambda e: (e["failures"], e["ns"]), default=None)


def cell(entry):
    if entry is None:
        return "-"
    wrong = f" !{entry['failures']}/{entry['checked']}" if entry["failures"] else ""
    return f"{entry['ns']:.0f} / {entry['max_error']:.0e}{wrong}"


def compared(rows):
    """Yields of each row its name, the entry of each column (None if a library has none), and the ratio of the
    fastest other library without a wrong answer to ours (None where there is none)."""
    for name in dict.fromkeys(row["row"] for row in rows):
        entries = [row for row in rows if row["row"] == name]
        cells = [better([e for e in entries if e["library"] in libraries]) for _, libraries in COLUMNS]
        others = [e["ns"] for e in cells[1:] if e is not None and e["failures"] == 0]
        yield name, cells, min(others) / cells[0]["ns"] if others else None


def times(rows):
    for name, cells, ratio in compared(rows):
        others = [e for e in cells[1:] if e is not None and e["failures"] == 0]
        slowest = [cells[0], *([min(others, key=lambda e: e["ns"])] if others else [])]
        yield [name, *map(cell, cells), f"{ratio:.1f}" if ratio else "-", f"{cells[0]['iterations']:.1f}",
               " / ".join(f"{entry['p99_ns']:.0f}" for entry in slowest)]


def facts(result):
    """Returns what TABLES.md says in its text by name: the rows in which another library is faster than ours, or
    slower by less than a quarter, with its ratio."""
    ties = [f"{name} ({ratio:.2f})" for name, _, ratio in compared(result["rows"]) if ratio and ratio < 1.25]
    return {"ties": ", ".join(ties) or "none"}


def questions(entries):
    for name in dict.fromkeys(entry["row"] for entry in entries):
        yield [name, *(f"{entry['ns']:.0f}" for entry in entries if entry["row"] == name)]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    asked = list(dict.fromkeys(entry["question"] for entry in result["questions"]))
    return {
        "times": (["ns / largest error [m]", *(name for name, _ in COLUMNS), "best other / ours", "our iterations",
                   "99th percentile, ours / best other"],
                  times(result["rows"])),
        "questions": (["ns of ours", *asked], questions(result["questions"])),
    }


def note(_):
    return "!n/m: n of m checked answers are wrong by more than 1e-3 or missing; such a library is not the best other"
