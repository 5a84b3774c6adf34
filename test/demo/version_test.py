#!/usr/bin/env python3
"""Each program tells the version of package.xml by --version, without a ROS master.

usage: version_test.py PROGRAM... [--gtest_output=xml:FILE]
"""

import os
import pathlib
import subprocess
import sys
import unittest
import xml.etree.ElementTree

import rosunit

PROGRAMS = [pathlib.Path(argument) for argument in sys.argv[1:] if not argument.startswith("--")]
MANIFEST = pathlib.Path(__file__).resolve().parents[2] / "package.xml"
PATIENCE = 60.0  # [s]


class Version(unittest.TestCase):
    def test_is_that_of_the_manifest(self):
        version = xml.etree.ElementTree.parse(MANIFEST).findtext("version")
        no_master = {**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1"}
        self.assertGreater(len(PROGRAMS), 3)
        for program in PROGRAMS:
            with self.subTest(program.name):
                result = subprocess.run([program, "--version"], env=no_master, text=True, timeout=PATIENCE,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                self.assertEqual(f"{program.name} of proximity_server {version}\n", result.stdout)
                self.assertEqual(0, result.returncode, result.stderr)


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "version_test", Version)
