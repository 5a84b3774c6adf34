"""Shows the result file of load_benchmark.py as a table: processor time until a robot is loaded and one state is answered.

usage: load_table.py RESULT.json
"""

from table import show_result


def loads(robots):
    for robot in robots:
        yield [robot["robot"], *(f"{robot[run]['processor']:.2f}" for run in ("first", "again"))]


def tables(result):
    """By name the head and the lines of each table that README.md shows."""
    return {"loads": (["processor time [s]", "first", "again"], loads(result["robots"]))}


if __name__ == "__main__":
    show_result(tables)
