"""The suites of a ctest build: which there are, and the test cases of a run.

usage: suites.py select BUILD_DIR REGEX WITHOUT     of those that are named FOLDER/NAME ("^scene/": of test/scene), prints which
                                                    REGEX selects and WITHOUT, where it is not empty, does not: the name, and
                                                    the targets that it needs
       suites.py count BUILD_DIR                    of those in BUILD_DIR/selected_suites, which were to run, the test cases
                                                    from the result files: the last line is "N passed, N failed, N skipped"

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


def suites(build):
    """(folder, name, command) of every suite."""
    listing = subprocess.check_output(["ctest", "--show-only=json-v1"], cwd=build)
    tests = pathlib.Path(build, "test").resolve()
    for test in json.loads(listing)["tests"]:
        folder = next(item["value"] for item in test["properties"] if item["name"] == "WORKING_DIRECTORY")
        yield pathlib.Path(folder).resolve().relative_to(tests), test["name"], " ".join(test.get("command", []))


def targets_of(name, command, known):
    """The targets that build what a suite needs: for a rostest the node and the programs that it starts."""
    rostest = re.search(r"\S+\.test\b", command)
    if not rostest:
        return [name] if name in known else []
    started = re.findall(r'type="(\w+)"', pathlib.Path(rostest[0]).read_text())
    return ["all", *(program for program in started if program in known)]


def select(build, regex, without):
    listing = subprocess.check_output(["ninja", "-C", build, "-t", "targets", "all"], text=True)
    known = {line.split(":")[0] for line in listing.splitlines()}
    for folder, name, command in suites(build):
        if re.search(regex, f"{folder}/{name}") and not (without and re.search(without, f"{folder}/{name}")):
            print(name, *targets_of(name, command, known))


def reason_of(skipped):
    """What a skipped case says, without the place in the source that gtest writes before it."""
    text = (skipped.get("message") or skipped.text or "").strip()
    return ": " + " ".join(re.sub(r"^\S+:\d+\n", "", text).split()) if text else ""


def cases(path):
    """(name, outcome) of every test case in one result file; raises OSError or ParseError. A skipped one tells why."""
    for case in ElementTree.parse(path).iter("testcase"):
        name = f'{case.get("classname")}.{case.get("name")}'
        skipped = case.find("skipped")
        if case.find("failure") is not None or case.find("error") is not None:
            yield name, "failed"
        elif skipped is not None:
            yield name + reason_of(skipped), "skipped"
        else:
            yield name, "skipped" if case.get("status") in ("notrun", "disabled") else "passed"


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
        # The process that names functions may be killed before ours, which then says so: no finding.
        text = re.sub(r".*WARNING: Can't write to symbolizer.*\n?", "", path.read_text(errors="replace"))
        if text and (not re.search(OUT_OF_MEMORY, text) or "runtime error:" in text):
            yield path.name, text


def ended_suites(build):
    """{name: (verdict, seconds)} of each suite that came to an end, from what ctest printed."""
    log = pathlib.Path(build, "test_results/ctest.log")
    text = log.read_text(errors="replace") if log.exists() else ""
    lines = re.findall(r"(?m)^ *\d+/\d+ Test +#\d+: (\S+) \.+ *(.*?) +([0-9.]+) sec", text)
    return {name: ("passed" if word == "Passed" else "failed", float(seconds)) for name, word, seconds in lines}


def count(build):
    selected = {line.split()[0] for line in pathlib.Path(build, "selected_suites").read_text().splitlines()}
    ended = ended_suites(build)
    counts = {"passed": 0, "failed": 0, "skipped": 0}
    for _, name, command in suites(build):
        for case, outcome in outcomes(name, command, ended.get(name, ("failed",))[0]) if name in selected else ():
            counts[outcome] += 1
            if outcome != "passed":
                print(f"{outcome}: {case}")
    for program, text in findings(build):
        counts["failed"] += 1
        print(f"{text}failed: {program}, see above")
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    return 0 if counts["passed"] and not counts["failed"] else 1


if __name__ == "__main__":
    sys.exit({"select": select, "count": count}[sys.argv[1]](*sys.argv[2:]))
