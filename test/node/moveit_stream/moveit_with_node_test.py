#!/usr/bin/env python3
"""From MoveIt's messages through moveit_stream to the objects of a running node."""

import os
import signal
import sys
import unittest
import xmlrpc.client

import geometry_msgs.msg
import rosgraph
import rospy
import rostest
import tf2_msgs.msg
from moveit_messages import CLASSES, box, scene
from moveit_stream_test import Stream, wait_for
from proximity_server.msg import ObjectList


NODE = "/proximity_server"


def process_of_node():
    uri = rosgraph.Master(rospy.get_name()).lookupNode(NODE)
    return xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2]


class MoveItWithNode(unittest.TestCase):
    def setUp(self):
        self.lists = []
        self.subscriber = rospy.Subscriber(f"{NODE}/objects", ObjectList, self.lists.append)

    def tearDown(self):
        self.subscriber.unregister()

    def wait_for_objects(self, *ids):
        def there():
            return bool(self.lists) and [thing.id for thing in self.lists[-1].objects] == list(ids)

        wait_for(there, f"no list of {ids}")
        return {thing.id: thing for thing in self.lists[-1].objects}

    def test_what_moveit_says_is_there_in_the_node(self):
        for version, classes in CLASSES.items():
            with Stream(server=NODE) as stream:
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

    def test_an_object_waits_for_its_frame(self):
        with Stream(server=NODE, tf_timeout=60.0) as stream:
            stream.publish("collision_object", box("noetic", "late", frame="table_frame"))
            stream.publish("collision_object", box("noetic", "next"))  # waits behind it
            frame = geometry_msgs.msg.TransformStamped(child_frame_id="table_frame")
            frame.header.frame_id = "base"
            frame.transform.translation.y = 2.0
            frame.transform.rotation.w = 1.0
            publisher = rospy.Publisher("/tf_static", tf2_msgs.msg.TFMessage, queue_size=1, latch=True)
            publisher.publish(tf2_msgs.msg.TFMessage([frame]))
            late = self.wait_for_objects("late", "next")["late"]
            self.assertEqual(("base", 2.0), (late.frame, late.pose.position.y))
            stream.publish("monitored_planning_scene", CLASSES["noetic"]["PlanningScene"](is_diff=False))
            self.wait_for_objects()

    def test_after_a_restart_of_the_node_its_objects_are_sent_again(self):
        with Stream(server=NODE) as stream:
            stream.publish("monitored_planning_scene", scene("noetic", "shelf", is_diff=False))
            self.wait_for_objects("shelf")
            first_start = self.lists[-1].node_start
            os.kill(process_of_node(), signal.SIGKILL)
            wait_for(lambda: self.lists[-1].node_start != first_start, "the node is not started again")
            self.wait_for_objects("shelf")
            self.assertEqual([("hand", "shelf", True)],
                             [(rule.a, rule.b, rule.allowed) for rule in self.lists[-1].rules])
            stream.publish("monitored_planning_scene", CLASSES["noetic"]["PlanningScene"](is_diff=False))
            self.wait_for_objects()

    def test_a_thousand_messages_in_a_second_are_all_applied(self):
        with Stream(server=NODE) as stream:
            ids = [f"box {number}" for number in range(10)]
            rate = rospy.Rate(1000)
            for number in range(1000):
                message = box("noetic", ids[number % 10])
                message.pose.position.y = float(number)
                stream.publish("collision_object", message)
                rate.sleep()
            stream.publish("collision_object", box("noetic", "last"))
            objects = self.wait_for_objects(*ids, "last")
            self.assertEqual([990.0 + number for number in range(10)], [objects[key].pose.position.y for key in ids])
            self.assertEqual([], stream.log)
            stream.publish("monitored_planning_scene", CLASSES["noetic"]["PlanningScene"](is_diff=False))
            self.wait_for_objects()


if __name__ == "__main__":
    rospy.init_node("moveit_with_node_test", argv=sys.argv)
    rostest.rosrun("proximity_server", "moveit_with_node", MoveItWithNode)
