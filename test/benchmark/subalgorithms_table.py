"""The result file of subalgorithms_benchmark as a table: a line a kind of simplices, a column an algorithm."""


def cell(entry):
    wrong = f" !{entry['failures']}" if entry["failures"] else ""
    return f"{entry['ns']:.0f} / {entry['max_error']:.0e}{wrong}"


def simplices(entries, algorithms):
    for kind in dict.fromkeys(entry["simplices"] for entry in entries):
        by_algorithm = {entry["algorithm"]: entry for entry in entries if entry["simplices"] == kind}
        yield [kind, *(cell(by_algorithm[algorithm]) for algorithm in algorithms)]


def tables(result):
    """By name the head and the lines of each table that README.md shows."""
    entries = result["subalgorithms"]
    algorithms = list(dict.fromkeys(entry["algorithm"] for entry in entries))
    return {"simplices": (["ns / largest error, relative", *algorithms], simplices(entries, algorithms))}
