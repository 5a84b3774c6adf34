#!/usr/bin/env python3
"""The example script, without a display."""

import os
import subprocess
import sys

import numpy

import cases
from cases import BALLS, DEMO, MODULE, SOURCE

SCRIPT = SOURCE / "src/python/examples/joint_space.py"


def run(*arguments):
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": MODULE}
    return subprocess.run([sys.executable, SCRIPT, *map(str, arguments)], env=environment, text=True, capture_output=True)


class JointSpace(cases.InFolder):
    def picture(self, path):
        import matplotlib.image
        return matplotlib.image.imread(path)

    def test_it_draws_the_robot_of_the_demo_and_tells_what_it_found(self):
        out = self.folder / "slice.png"
        result = run(DEMO / "robot.urdf", "--srdf", DEMO / "robot.srdf", "--package", SOURCE, "--states", 300, "--cells", 20,
                     "--joints", "left_shoulder_pan", "left_elbow_flex", "--at", "left_shoulder_lift=0.5", "--out", out)
        self.assertEqual("", result.stderr)
        self.assertEqual(0, result.returncode)
        self.assertRegex(result.stdout, r"300 states: \d+\.\d % in contact, smallest distance -?0\.\d+ m of \w+ - \w+")
        pixels = self.picture(out)
        self.assertGreater(min(pixels.shape[:2]), 300)
        self.assertGreater(len(numpy.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)), 200)

    def test_it_does_not_replace_what_it_reads(self):
        urdf = self.file("balls.urdf", BALLS)
        link = self.folder / "link.png"
        link.symlink_to(urdf)
        result = run(urdf, "--joints", "turn", "up", "--out", link)
        self.assertEqual(2, result.returncode)
        self.assertIn(f"--out {link}: is the same file as {urdf}, which is read", result.stderr)
        self.assertEqual(BALLS, (self.folder / "balls.urdf").read_text())

    def test_a_slice_without_contact_is_drawn_too(self):
        urdf = self.file("balls.urdf", BALLS)
        result = run(urdf, "--states", 10, "--cells", 10, "--joints", "turn", "up", "--out", self.folder / "slice.png")
        self.assertEqual(("", 0), (result.stderr, result.returncode))
        self.assertIn("0.0 % in contact", result.stdout)

    def test_a_joint_that_does_not_exist_is_named(self):
        robot = (DEMO / "robot.urdf", "--package", SOURCE, "--out", self.folder / "a.png", "--joints", "left_elbow_flex")
        for wrong in (("elbow",), ("left_shoulder_pan", "--at", "elbow=0.5")):
            with self.subTest(wrong):
                result = run(*robot, *wrong)
                self.assertEqual(2, result.returncode)
                self.assertIn("joint_space.py: error: there is no joint elbow", result.stderr)
        self.assertFalse((self.folder / "a.png").exists())


if __name__ == "__main__":
    cases.main()
