#!/usr/bin/env python3
"""Checks that each test suite of a program that several rostests share runs in exactly one of them, that of its source.

usage: rostest_filters_test.py SOURCE_DIR
"""

import fnmatch
import pathlib
import re
import sys
import unittest

SOURCE = pathlib.Path(sys.argv[1]).resolve()


def rostests():
    """(.test file, program, patterns) of each test with a filter."""
    for path in sorted(SOURCE.glob("test/**/*.test")):
        for program, patterns in re.findall(r'type="(\w+)" args="--gtest_filter=(\S+)"', path.read_text()):
            yield path, program, patterns.split(":")


def suites_of(source):
    """The names that a filter sees; a suite with parameters has that of its instances before its own."""
    for kind, name in set(re.findall(r"(?m)^TEST(_F|_P)?\(\s*(\w+)", source.read_text())):
        yield f"Any/{name}.Any/0" if kind == "_P" else f"{name}.Any"


class RostestFilters(unittest.TestCase):
    def test_each_suite_runs_with_its_own_test_file(self):
        tests = list(rostests())
        self.assertTrue(tests)
        for own, program, _ in tests:
            source = own.with_name(own.stem + "_test.cpp")
            for suite in suites_of(source):
                running = [path for path, other, patterns in tests
                           if other == program and any(fnmatch.fnmatchcase(suite, pattern) for pattern in patterns)]
                self.assertEqual(running, [own], f"{suite} of {source}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
