"""Shows the result file of load_benchmark.py as a table: processor time until a robot is loaded and one state is answered.

usage: load_table.py RESULT.json
"""

import json
import sys

from table import show


def loads(robots):
    for robot in robots:
        yield [robot["robot"], *(f"{robot[run]['processor']:.2f}" for run in ("first", "again"))]


def tables(result):
    """By name the head and the lines of each table that README.md shows."""
    return {"loads": (["processor time [s]", "first", "again"], loads(result["robots"]))}


def main(path):
    with open(path) as file:
        result = json.load(file)
    for head, lines in tables(result).values():
        show(head, lines)


if __name__ == "__main__":
    main(sys.argv[1])
