"""Makes a table of the result file of load_benchmark.py: processor time until a robot is loaded and a state is
answered."""


def loads(robots):
    for robot in robots:
        yield [robot["robot"], *(f"{robot[run]['processor']:.2f}" for run in ("first", "again"))]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    return {"loads": (["processor time [s]", "first", "again"], loads(result["robots"]))}
