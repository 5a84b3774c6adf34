#!/usr/bin/env python3
"""pair_audit --setup makes a folder whose rostest passes at once, and fails where the robot rests in a collision.

usage: robot_setup_test.py PAIR_AUDIT [--gtest_output=xml:FILE]
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import rosunit

PAIR_AUDIT = sys.argv[1]
DEMO = pathlib.Path(__file__).resolve().parents[2] / "config/demo"
PATIENCE = 300.0  # [s]


class RobotSetup(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="robot_setup_")
        cls.folder = pathlib.Path(cls.temporary.name, "demo_proximity")
        subprocess.run([PAIR_AUDIT, DEMO / "robot.urdf", "--samples", "5000", "--setup", cls.folder],
                       check=True, capture_output=True, timeout=PATIENCE)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def rostest(self):
        """The result of the folder's rostest, which has a ROS master of its own."""
        environment = {**os.environ, "ROS_HOME": self.temporary.name, "ROS_TEST_RESULTS_DIR": self.temporary.name}
        return subprocess.run(
            ["rostest", "--package", "demo_proximity", "--pkgdir", self.folder, self.folder / "proximity.test"],
            env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=PATIENCE)

    def test_its_rostest_passes(self):
        result = self.rostest()
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn("RESULT: SUCCESS", result.stdout)

    def test_its_rostest_fails_in_a_collision(self):
        rest = self.folder / "rest.yaml"
        clear = rest.read_text()
        # A shoulder is 12 mm inside the torso.
        rest.write_text("joints: [left_shoulder_pan, left_shoulder_lift]\n"
                        "keyframes: [[0, -0.4751, 0.5377], [1, -0.4751, 0.5377]]\n")
        try:
            result = self.rostest()
        finally:
            rest.write_text(clear)
        self.assertNotEqual(result.returncode, 0, result.stdout)
        self.assertIn("COLLISION", result.stdout)


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "robot_setup_test", RobotSetup)
