"""Shows the result file of subalgorithms_benchmark as tables: a line for each kind of simplices, a column for each algorithm;
then every entry in full.

usage: subalgorithms_table.py RESULT.json
"""

from table import show, show_result


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


def details(entries):
    for entry in entries:
        yield [entry["simplices"], entry["algorithm"], f"{entry['ns']:.3g}", f"{entry['mean_iterations']:.3f}",
               f"{entry['max_error']:.1e}", str(entry["failures"])]


def main():
    result = show_result(tables)
    show(["simplices", "algorithm", "ns", "iterations", "largest error", "failures of 500"], details(result["subalgorithms"]))


if __name__ == "__main__":
    main()
