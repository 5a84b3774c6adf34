"""Makes tables of a result file of subalgorithms_benchmark: a line for each kind of simplices, a column for each
algorithm; then every entry in full.
"""


def cell(entry):
    wrong = f" !{entry['failures']}" if entry["failures"] else ""
    return f"{entry['ns']:.0f} / {entry['max_error']:.0e}{wrong}"


def simplices(entries, algorithms):
    for kind in dict.fromkeys(entry["simplices"] for entry in entries):
        by_algorithm = {entry["algorithm"]: entry for entry in entries if entry["simplices"] == kind}
        yield [kind, *(cell(by_algorithm[algorithm]) for algorithm in algorithms)]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    entries = result["subalgorithms"]
    algorithms = list(dict.fromkeys(entry["algorithm"] for entry in entries))
    return {"simplices": (["ns / largest error, relative", *algorithms], simplices(entries, algorithms))}


def details(result):
    """Returns the head and the lines of each table that only the terminal shows."""
    lines = [[entry["simplices"], entry["algorithm"], f"{entry['ns']:.3g}", f"{entry['mean_iterations']:.3f}",
              f"{entry['max_error']:.1e}", str(entry["failures"])] for entry in result["subalgorithms"]]
    return [(["simplices", "algorithm", "ns", "iterations", "largest error", "failures of 500"], lines)]
