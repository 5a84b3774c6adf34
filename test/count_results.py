"""Counts the test cases of a ctest run from its result files: the last line is "N passed, N failed, N skipped".

usage: count_results.py BUILD_DIR REGEX     (the suites that REGEX selects were to run)

A case counts once, from the file of its own suite. A suite that did not run, crashed, timed out or left no readable
result file is one failure, and so is what a sanitizer found in one program: it is printed in full. That a program got no
more memory is no finding: what that breaks shows in the cases. Exit code 0 only if something passed and nothing failed.
"""

import json
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

OUT_OF_MEMORY = "allocator is out of memory|failed to allocate|exceeds maximum supported size|Failed to mmap"


def suites(build, regex):
    """(name, command) of every suite that was to run."""
    listing = subprocess.check_output(["ctest", "--test-dir", build, "-R", regex, "--show-only=json-v1"])
    return [(test["name"], " ".join(test.get("command", []))) for test in json.loads(listing)["tests"]]


def cases(path):
    """(name, outcome) of every test case in one result file; raises OSError or ParseError."""
    for case in ElementTree.parse(path).iter("testcase"):
        bad = case.find("failure") is not None or case.find("error") is not None
        unrun = case.find("skipped") is not None or case.get("status") in ("notrun", "disabled")
        outcome = "failed" if bad else "skipped" if unrun else "passed"
        yield f'{case.get("classname")}.{case.get("name")}', outcome


def result_files(command):
    """The files in which a suite reports its cases: none for a bare command, one per <test> for a rostest."""
    gtest = re.findall(r"--gtest_output=xml:(\S+)", command)
    rostest = re.findall(r"run_tests\.py (\S+)", command)
    for path in rostest:
        text = pathlib.Path(path).read_text(errors="replace")
        gtest += re.findall(r"results are in \[(.*?)\]", text)
    return gtest


def outcomes(name, command, verdict):
    """Every (case, outcome) of one suite, given what ctest says about the whole of it."""
    try:
        files = result_files(command)
        found = [case for path in files for case in cases(path)]
    except (OSError, ElementTree.ParseError) as error:
        return [(f"{name} left no result: {error}", "failed")]
    if not files:
        found = [(name, verdict)]
    if not found:
        return [(f"{name} has no test case", "failed")]
    if verdict == "failed" and not any(outcome == "failed" for _, outcome in found):
        found.append((f"{name} did not end well", "failed"))
    return found


def findings(build):
    """(program, text) of all that sanitizers found, from the files into which ./dev lets them write."""
    for path in sorted(pathlib.Path(build, "findings").glob("*")):
        text = path.read_text(errors="replace")
        if not re.search(OUT_OF_MEMORY, text) or "runtime error:" in text:
            yield path.name, text


def main(build, regex):
    verdicts = {}
    for path in pathlib.Path(build, "test_results").glob("ctest*.xml"):
        for case in ElementTree.parse(path).iter("testcase"):
            verdicts[case.get("name")] = "passed" if case.get("status") == "run" else "failed"

    counts = {"passed": 0, "failed": 0, "skipped": 0}
    for name, command in suites(build, regex):
        for case, outcome in outcomes(name, command, verdicts.get(name, "failed")):
            counts[outcome] += 1
            if outcome != "passed":
                print(f"{outcome}: {case}")
    for program, text in findings(build):
        counts["failed"] += 1
        print(f"{text}failed: {program}, see above")
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    return 0 if counts["passed"] and not counts["failed"] else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
