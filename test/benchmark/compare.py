"""Shows a result file of narrowphase_benchmark as a table: median nanoseconds a query, one column a library.

usage: compare.py RESULT.json
"""

import json
import sys


def main(path):
    rows, libraries = {}, []
    with open(path) as result:
        runs = json.load(result)["benchmarks"]
    for run in sorted(runs, key=lambda run: run["family_index"]):
        if run.get("aggregate_name") == "median":
            row, library = run["run_name"].rsplit("/", 1)
            rows.setdefault(row, {})[library] = run["cpu_time"]
            libraries += [library] if library not in libraries else []
    print(f'{"median ns":20}' + "".join(f"{library:>10}" for library in libraries) + "   best other / ours")
    for row, times in rows.items():
        others = [time for library, time in times.items() if library != "ours"]
        ratio = f'{min(others) / times["ours"]:20.1f}' if others and "ours" in times else ""
        print(f"{row:20}" + "".join(f"{times.get(library, float('nan')):10.0f}" for library in libraries) + ratio)


if __name__ == "__main__":
    main(sys.argv[1])
