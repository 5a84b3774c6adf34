#!/usr/bin/env python3
"""setup_table.py makes the rows that src/tools/pair_audit/README.md has, of three of the 24 robots.

usage: setup_table_test.py PAIR_AUDIT [--gtest_output=xml:FILE]
"""

import pathlib
import sys
import unittest

import rosunit

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import setup_table  # noqa: E402

PAIR_AUDIT = sys.argv[1]
SOURCE = pathlib.Path(__file__).resolve().parents[2]
ROBOTS = SOURCE.parent / "shared" / "robots"
README = SOURCE / "src" / "tools" / "pair_audit" / "README.md"


@unittest.skipUnless((ROBOTS / "public_robots").exists(), f"there is no {ROBOTS}/public_robots")
class SetupTable(unittest.TestCase):
    def of(self, name):
        """All cells but the seconds are those of the README, and those of the README are at most five minutes."""
        cells = setup_table.row_of(name, PAIR_AUDIT, ROBOTS)
        shown = next(line for line in README.read_text().splitlines() if line.startswith(f"| {name} |")).strip("| ").split(" | ")
        self.assertEqual(cells[:-1], shown[:-1])
        self.assertEqual(cells[-2], "passes")
        self.assertLessEqual(float(shown[-1]), 300.0)

    def test_a_robot_that_needs_no_decision(self):
        self.of("iiwa14")

    def test_a_robot_with_overlaps(self):
        self.of("Stretch SE3")

    def test_a_robot_with_an_srdf(self):
        self.of("UR5")


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "setup_table_test", SetupTable)
