#!/usr/bin/env python3
"""Messages of MoveIt for tests, and a publisher of one of them. Not a test by itself.

usage: moveit_messages.py TOPIC melodic|noetic|string|foreign    (foreign: another message of the name of MoveIt's)
"""

import sys

import genpy.dynamic
import moveit_definitions
import rospy
import std_msgs.msg

CLASSES = {version: moveit_definitions.classes_of(version) for version in moveit_definitions.VERSIONS}


def box(version, key, frame=""):
    """An ADD of a box whose shape has a pose, and the object none."""
    classes = CLASSES[version]
    message = classes["CollisionObject"](id=key)
    message.header.frame_id = frame
    message.primitives = [classes["SolidPrimitive"](type=1, dimensions=[0.1, 0.2, 0.3])]
    message.primitive_poses = [classes["Pose"]()]
    message.primitive_poses[0].position.x = 1.5
    return message


def attached(version, key):
    return CLASSES[version]["AttachedCollisionObject"](link_name="hand", touch_links=["finger"], object=box(version, key))


def scene(version, key, is_diff):
    """A box that the hand may touch."""
    classes = CLASSES[version]
    message = classes["PlanningScene"](is_diff=is_diff)
    message.world.collision_objects = [box(version, key)]
    message.allowed_collision_matrix.entry_names = ["hand", key]
    message.allowed_collision_matrix.entry_values = [classes["AllowedCollisionEntry"]([False, True]),
                                                     classes["AllowedCollisionEntry"]([True, False])]
    return message


def message_of(what):
    if what == "string":
        return std_msgs.msg.String("box")
    if what == "foreign":
        name = "moveit_msgs/CollisionObject"
        return genpy.dynamic.generate_dynamic(name, "string id\nuint8 operation\n")[name](id="box")
    return box(what, f"box of {what}")


if __name__ == "__main__":
    topic, what = sys.argv[1:3]
    rospy.init_node("publisher", anonymous=True)
    message = message_of(what)
    publisher = rospy.Publisher(topic, type(message), queue_size=1, latch=True)
    publisher.publish(message)
    rospy.spin()
