#!/usr/bin/env python3
"""clearancetest beside the node while a bag is played, whose times are those of its recording."""

import os
import subprocess
import tempfile
import unittest

import rosbag
import rospy
import rostest
import sensor_msgs.msg
from clearancetest_child import Child, gantry_at

START, SECONDS = 1.5e9, 4.0  # [s] of the recording


def record(path):
    """The ball of gantry.urdf goes from x = 0.6 to x = 0.4: it comes from 0.4 m to 0.2 m from the base."""
    with rosbag.Bag(path, "w") as bag:
        for n in range(int(SECONDS * 50)):
            stamp = rospy.Time.from_sec(START + 0.02 * n)
            x = 0.6 - 0.2 * 0.02 * n / SECONDS
            state = sensor_msgs.msg.JointState(name=["x_axis"], position=[x])
            state.header.stamp = stamp
            bag.write("/joint_states", state, stamp)
            bag.write("/tf", gantry_at(x, stamp), stamp)


class PlayedBag(unittest.TestCase):
    def run_beside_bag(self, **parameters):
        folder = tempfile.TemporaryDirectory()
        path = os.path.join(folder.name, "gantry.bag")
        record(path)
        # The bag begins again and again, so that the clock jumps back.
        player = subprocess.Popen(["/usr/lib/rosbag/play", "--clock", "--loop", "--quiet", path],
                                  stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        try:
            # After each jump the node knows nothing until transforms come.
            return Child(duration=2 * SECONDS, max_invalid=1.0, max_silence=1.0, **parameters).cases()
        finally:
            player.terminate()
            player.wait()
            folder.cleanup()

    def test_a_bag_that_keeps_clear(self):
        self.assertEqual(set(self.run_beside_bag(minimum=0.19, pairs=[["base", "ball"]], min_rate=5.0).values()), {""})

    def test_a_bag_that_comes_too_close(self):
        words = self.run_beside_bag(minimum=0.3)["test_minimum"]
        # Close to the end of the recording, where x is close to 0.4.
        self.assertRegex(words, r"Worst: at 150000000[34]\.\d+ s base - ball: distance 0\.2\d* m")
        self.assertRegex(words, r"joints: x_axis=0\.4\d*")


if __name__ == "__main__":
    rospy.init_node("clearancetest_bag_test")
    rostest.rosrun("proximity_server", "clearancetest_bag", PlayedBag)
