"""Where the time of a ./dev command went: its stages, the build by folder, the slowest suites. Kept as a file, too.

usage: times.py record BUILD_DIR NINJA_LOG COMMAND [STAGE=MICROSECONDS...]     prints it, and names the file it wrote
       times.py compare FILE FILE                                              two such files, side by side

The steps of the build are those of ninja's log that NINJA_LOG, the log of before, does not have; the times of the suites are those
that ctest printed.
"""

import collections
import datetime
import json
import pathlib
import re
import sys

import suites

SLOWEST = 10


def ninja_steps(log):
    """{(output, end, hash): seconds} of ninja's log; what a step made besides its first output is left out."""
    steps, seen = {}, set()
    for line in log.read_text().splitlines()[1:] if log.exists() else ():
        start, end, _, output, command = line.split("\t")
        if (start, end, command) not in seen:
            steps[output, end, command] = (int(end) - int(start)) / 1000
            seen.add((start, end, command))
    return steps


def folder_of(output):
    """src/scene, test/node, ... of an object file, "messages" of what ROS generates, else "links, and others"."""
    match = re.match(r"((?:src|test)/\w+)/.*CMakeFiles/", output)
    if match:
        return match[1]
    return "messages" if re.search(r"devel/(include|share|lib/python)", output) else "links and the rest"


def new_steps(build, log_before):
    """{output: seconds} of the steps that are not in the log of before."""
    before = ninja_steps(log_before)
    return {key[0]: seconds for key, seconds in ninja_steps(build / ".ninja_log").items() if key not in before}


def suites_of(build):
    """{suite: seconds} of the last ctest."""
    return {name: seconds for name, (_, seconds) in suites.ended_suites(build).items()}


def folders(steps):
    """{folder: [steps, seconds]}"""
    sums = collections.defaultdict(lambda: [0, 0.0])
    for output, seconds in steps.items():
        sums[folder_of(output)][0] += 1
        sums[folder_of(output)][1] += seconds
    return dict(sums)


def slowest(seconds):
    return sorted(seconds.items(), key=lambda item: -item[1])[:SLOWEST]


def record(build, log_before, command, *stages):
    build = pathlib.Path(build)
    stages = {name: int(microseconds) / 1e6 for name, microseconds in (stage.split("=") for stage in stages)}
    steps = new_steps(build, pathlib.Path(log_before)) if "build" in stages else {}
    times = {"command": command, "stages": stages, "build": folders(steps), "steps": steps,
             "suites": suites_of(build) if "tests" in stages else {}}
    stamp = datetime.datetime.now().strftime("%Y-%m-%dT%H.%M.%S")
    path = build / "times" / f"{stamp}_{re.sub('[^a-z]+', '_', command)}.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(times, indent=1))

    print(f"{sum(stages.values()):.0f} s: " + ", ".join(f"{name} {seconds:.0f}" for name, seconds in stages.items()))
    rows = sorted(times["build"].items(), key=lambda row: -row[1][1])
    if rows:
        print("build, in seconds of one core: " + ", ".join(f"{name} {seconds:.0f} ({count})" for name, (count, seconds) in rows))
    for title, seconds in (("steps", steps), ("suites", times["suites"])):
        if seconds:
            print(f"slowest {title}: " + ", ".join(f"{pathlib.PurePath(name).name} {spent:.1f}" for name, spent in slowest(seconds)))
    print(f"kept in {path}")


def flat(times):
    """{row: seconds} of all that two files are compared by."""
    rows = {"all": sum(times["stages"].values()), **times["stages"]}
    rows.update({f"build {name}": seconds for name, (_, seconds) in times["build"].items()})
    rows.update({f"suite {name}": seconds for name, seconds in times["suites"].items()})
    return rows


def compare(*paths):
    first, second = (flat(json.loads(pathlib.Path(path).read_text())) for path in paths)
    print(f"{'first':>8} {'second':>8} {'ratio':>6}   [s]")
    shown = dict(slowest({row: max(first.get(row, 0.0), second.get(row, 0.0)) for row in {**first, **second} if row.startswith("suite")}))
    for row in {**first, **second}:
        if row.startswith("suite") and row not in shown:
            continue
        a, b = first.get(row), second.get(row)
        cells = ["-" if cell is None else f"{cell:.1f}" for cell in (a, b)]
        print(f"{cells[0]:>8} {cells[1]:>8} {f'{b / a:.2f}' if a and b else '':>6}   {row}")


if __name__ == "__main__":
    {"record": record, "compare": compare}[sys.argv[1]](*sys.argv[2:])
