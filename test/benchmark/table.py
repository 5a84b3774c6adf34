"""Shows a result file of narrowphase_benchmark as tables: median nanoseconds a query / largest error, a column a library;
and median nanoseconds of ours, a column a question.

usage: table.py RESULT.json            for a terminal
       table.py RESULT.json --markdown for README.md
"""

import json
import sys

COLUMNS = [  # the better of those that share a column
    ("ours", ["ours"]),
    ("FCL libccd", ["FCL libccd"]),
    ("FCL INDEP", ["FCL INDEP"]),
    ("libccd", ["libccd"]),
    ("Bullet", ["Bullet GJK", "Bullet EPA2"]),
]


def better(entries):
    """The one with fewer gross errors, then the faster."""
    return min(entries, key=lambda e: (e["failures"], e["ns"]), default=None)


def cell(entry):
    if entry is None:
        return "-"
    wrong = f" !{entry['failures']}/{entry['checked']}" if entry["failures"] else ""
    return f"{entry['ns']:.0f} / {entry['max_error']:.0e}{wrong}"


def table(rows):
    for name in dict.fromkeys(row["row"] for row in rows):
        entries = [row for row in rows if row["row"] == name]
        cells = [better([e for e in entries if e["library"] in libraries]) for _, libraries in COLUMNS]
        others = [e["ns"] for e in cells[1:] if e is not None and e["failures"] == 0]
        ratio = f"{min(others) / cells[0]['ns']:.1f}" if others else "-"
        yield [name, *map(cell, cells), ratio, f"{cells[0]['iterations']:.1f}"]


def questions(entries):
    for name in dict.fromkeys(entry["row"] for entry in entries):
        yield [name, *(f"{entry['ns']:.0f}" for entry in entries if entry["row"] == name)]


def show(head, lines, markdown):
    lines = [head, *lines]
    if markdown:
        lines.insert(1, ["---"] * len(head))
        print("\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n")
        return
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    print("\n".join("  ".join(text.ljust(width) for text, width in zip(line, widths)).rstrip() for line in lines) + "\n")


def main(path, markdown):
    with open(path) as file:
        result = json.load(file)
    show(["ns / largest error [m]", *(name for name, _ in COLUMNS), "best other / ours", "our iterations"],
         table(result["rows"]), markdown)
    asked = list(dict.fromkeys(entry["question"] for entry in result["questions"]))
    show(["ns of ours", *asked], questions(result["questions"]), markdown)
    if not markdown:
        print("!n/m: n of m checked answers are wrong by more than 1e-3 or missing; such a library is not the best other")


if __name__ == "__main__":
    main(sys.argv[1], "--markdown" in sys.argv[2:])
