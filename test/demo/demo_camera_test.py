#!/usr/bin/env python3
"""The simulated camera of the demo sees a box, of which the node knows nothing else, come near and go."""

import queue
import time
import unittest

import rospy
import rostest
from proximity_server.msg import Clearance, ObjectList, Sensed

SERVER = "/proximity_server/"
PATIENCE = 60.0  # [s]


class DemoCamera(unittest.TestCase):
    def next(self, topic, kind, accept):
        """The next message that is accepted."""
        messages = queue.Queue()
        subscriber = rospy.Subscriber(SERVER + topic, kind, messages.put)
        deadline = time.monotonic() + PATIENCE
        try:
            while True:
                message = messages.get(timeout=max(0.0, deadline - time.monotonic()))
                if accept(message):
                    return message
        except queue.Empty:
            return self.fail(f"in vain: {topic}")
        finally:
            subscriber.unregister()

    def test_a_box_comes_near_and_goes(self):
        clearance = lambda level: self.next("clearance", Clearance, lambda message: message.level == level)
        for _ in range(2):
            clearance(Clearance.CLEAR)
            stop = clearance(Clearance.STOP)
            self.assertEqual("camera", stop.deciding.b.link)
            self.assertIn(stop.deciding.a.link, ("right_hand", "right_wrist", "right_forearm"))
        clearance(Clearance.CLEAR)
        objects = self.next("objects", ObjectList, lambda message: True)
        self.assertEqual({"bar", "stand", "table", "table_leg"}, {known.id for known in objects.objects})

    def test_all_points_are_of_the_robot_while_there_is_no_box(self):
        camera = lambda accept: self.next("sensed", Sensed, lambda message: message.sources and accept(message.sources[0])).sources[0]
        seen = camera(lambda source: source.voxels > 0)
        self.assertEqual("camera", seen.name)
        self.assertGreater(seen.points, seen.on_robot)
        unseen = camera(lambda source: source.points > 0 and source.voxels == 0)
        self.assertEqual(unseen.points, unseen.on_robot)


if __name__ == "__main__":
    rospy.init_node("demo_camera_test")
    rostest.rosrun("proximity_server", "demo_camera_test", DemoCamera)
