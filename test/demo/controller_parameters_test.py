#!/usr/bin/env python3
"""What the example controller says of parameters and a system with which it cannot drive."""

import pathlib
import subprocess
import sys
import threading
import unittest

import rospy
import rostest

PROGRAM = pathlib.Path(__file__).resolve().parents[2] / "src/demo/avoiding_controller/avoiding_controller"
PATIENCE = 20.0  # [s]


class ControllerParameters(unittest.TestCase):
    def assert_refused(self, reason, *arguments):
        """The controller ends with one message that has `reason` in it."""
        name = "controller_of_" + self.id().rsplit(".", 1)[-1]
        done = subprocess.run([PROGRAM, f"__name:={name}", *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, timeout=PATIENCE)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn(reason.replace("~", f"/{name}/"), done.stdout)
        self.assertNotIn("Traceback", done.stdout)

    def test_names_an_unknown_joint(self):
        self.assert_refused("~target: the robot has no joint elbow that can be driven", "_target:={elbow: 1.0}")

    def test_names_a_position_that_is_no_number(self):
        self.assert_refused("~target/head_pan is left, not a number", "_target:={head_pan: left}")

    def test_names_a_target_beyond_the_limits(self):
        self.assert_refused("~target/left_elbow_flex is -100, outside of its limits [", "_target:={left_elbow_flex: -100}")

    def test_names_a_start_beyond_the_limits(self):
        self.assert_refused("~start/left_elbow_flex is 100, outside of its limits [", "_start:={left_elbow_flex: 100}")

    def test_names_a_target_that_is_no_map(self):
        self.assert_refused("~target must map names of joints to positions", "_target:=[1.0, 2.0]")

    def test_names_a_rate_of_zero(self):
        self.assert_refused("~rate is 0, not a positive number", "_rate:=0")

    def test_names_a_speed_that_is_no_number(self):
        self.assert_refused("~max_speed is fast, not a positive number", "_max_speed:=fast")

    def test_names_a_negative_allowance(self):
        self.assert_refused("~allowance is -0.1, not a number of at least 0", "_allowance:=-0.1")

    def test_names_the_robot_description_that_is_not_set(self):
        self.assert_refused("parameter /none is not set", "robot_description:=none")

    def test_names_a_robot_description_that_is_no_urdf(self):
        rospy.set_param("/text", "a robot")
        self.assert_refused("robot_description is no URDF", "robot_description:=text")

    def test_says_that_no_rows_come(self):
        with subprocess.Popen([PROGRAM, "__name:=waiting", "_server:=/nobody"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True) as controller:
            end = threading.Timer(PATIENCE, controller.kill)
            end.start()
            line = controller.stdout.readline()
            end.cancel()
            controller.kill()
        self.assertIn("The robot rests: /nobody/constraints has no rows of this state", line)


if __name__ == "__main__":
    rospy.init_node("controller_parameters_test")
    rostest.rosrun("proximity_server", "controller_parameters_test", ControllerParameters, sys.argv)
