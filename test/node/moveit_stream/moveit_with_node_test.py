#!/usr/bin/env python3
"""From MoveIt's messages through moveit_stream to the objects of a running node."""

import sys
import unittest

import rospy
import rostest
from moveit_messages import CLASSES, box, scene
from moveit_stream_test import Stream, wait_for
from proximity_server.msg import ObjectList


class MoveItWithNode(unittest.TestCase):
    def setUp(self):
        self.lists = []
        self.subscriber = rospy.Subscriber("/proximity_server/objects", ObjectList, self.lists.append)

    def tearDown(self):
        self.subscriber.unregister()

    def wait_for_objects(self, *ids):
        def there():
            return bool(self.lists) and [thing.id for thing in self.lists[-1].objects] == list(ids)

        wait_for(there, f"no list of {ids}")
        return {thing.id: thing for thing in self.lists[-1].objects}

    def test_what_moveit_says_is_there_in_the_node(self):
        for version, classes in CLASSES.items():
            with Stream(server="/proximity_server") as stream:
                stream.publish("monitored_planning_scene", scene(version, "shelf", is_diff=False))
                shelf = self.wait_for_objects("shelf")["shelf"]
                self.assertEqual(("base", ""), (shelf.frame, shelf.link))
                self.assertEqual([("hand", "shelf", True)],
                                 [(rule.a, rule.b, rule.allowed) for rule in self.lists[-1].rules])
                bar = classes["AttachedCollisionObject"](link_name="ball", touch_links=["block"], object=box(version, "bar"))
                bar.object.header.frame_id = "ball"
                stream.publish("attached_collision_object", bar)
                bar = self.wait_for_objects("bar", "shelf")["bar"]
                self.assertEqual(("ball", ["block"]), (bar.link, bar.touch_links))
                stream.publish("monitored_planning_scene", classes["PlanningScene"](is_diff=False))
                self.wait_for_objects()
                self.assertEqual([], stream.log)


if __name__ == "__main__":
    rospy.init_node("moveit_with_node_test", argv=sys.argv)
    rostest.rosrun("proximity_server", "moveit_with_node", MoveItWithNode)
