"""The speeds that the URDF on the parameter server allows."""

import xml.etree.ElementTree

import numpy
import rospy


def joints_that_are_too_fast(states):
    """{joint: its largest speed in these JointStates [rad/s, m/s]}, of those that are above the limit of the URDF."""
    limits = {joint.get("name"): float(joint.find("limit").get("velocity"))
              for joint in xml.etree.ElementTree.fromstring(rospy.get_param("robot_description")).iter("joint")
              if joint.find("limit") is not None}
    fastest = numpy.abs([state.velocity for state in states]).max(axis=0)
    return {name: speed for name, speed in zip(states[0].name, fastest) if speed > limits[name] + 1e-9}
