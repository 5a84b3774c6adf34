#!/usr/bin/env python3
"""The example controller drives the demo robot towards a target through its own arm, beside a running node."""

import sys
import threading
import unittest

import numpy
import rospy
import rostest
from proximity_server.msg import Clearance
from proximity_server.srv import QueryConfiguration, QueryConfigurationRequest
from sensor_msgs.msg import JointState
from urdf_speeds import joints_that_are_too_fast

NODE = "/proximity_server"
PATIENCE = 60.0  # [s]
ARRIVED = 0.01  # [rad, m] the norm of what is left to go


class Recorder:
    """The states that the controller publishes, and the clearances of the node."""

    def __init__(self):
        self.changed = threading.Condition()
        self.states, self.clearances = [], []
        self.subscribers = [rospy.Subscriber("joint_states", JointState, self.add, self.states),
                            rospy.Subscriber(f"{NODE}/clearance", Clearance, self.add, self.clearances)]

    def add(self, message, messages):
        with self.changed:
            messages.append(message)
            self.changed.notify_all()

    def wait_for(self, condition, what):
        with self.changed:
            if not self.changed.wait_for(condition, PATIENCE):
                raise AssertionError(f"after {PATIENCE} s there is not yet {what}")


class AvoidingController(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Waits for the whole motion."""
        cls.stop_distance = rospy.get_param(f"{NODE}/stop_distance", 0.02)
        recorder = Recorder()
        recorder.wait_for(lambda: recorder.states, "a state of the robot")
        cls.names = recorder.states[0].name
        cls.start = cls.positions("start", numpy.zeros(len(cls.names)))
        cls.target = cls.positions("target", cls.start)
        recorder.wait_for(lambda: numpy.linalg.norm(cls.target - recorder.states[-1].position) < ARRIVED, "an arrival")
        with recorder.changed:
            cls.states, cls.clearances = list(recorder.states), list(recorder.clearances)

    @classmethod
    def positions(cls, parameter, others):
        named = rospy.get_param(f"/avoiding_controller/{parameter}")
        return numpy.array([named.get(name, other) for name, other in zip(cls.names, others)])

    def distances_of(self, positions):
        """The smallest distance in each of these states, as a service of the node has it."""
        states = [JointState(name=self.names, position=p) for p in positions]
        request = QueryConfigurationRequest(states=states, mode=QueryConfigurationRequest.MINIMUM)
        answer = rospy.ServiceProxy(f"{NODE}/query_configuration", QueryConfiguration)(request)
        self.assertTrue(answer.success, answer.status.message)
        return [state.minimum for state in answer.states]

    def test_the_straight_way_leads_through_the_own_arm(self):
        shares = numpy.linspace(0.0, 1.0, 100)
        distances = [pair.distance for pair in self.distances_of(self.start + share * (self.target - self.start) for share in shares)]
        self.assertGreater(min(distances[0], distances[-1]), self.stop_distance)
        self.assertLess(min(distances), -0.02)

    def test_no_state_of_the_robot_is_below_the_stop_distance(self):
        self.assertGreater(len(self.states), 300)
        distances = self.distances_of([state.position for state in self.states])
        self.assertGreaterEqual(min(pair.lower_bound for pair in distances), self.stop_distance)

    def test_no_clearance_of_the_node_is_below_the_stop_distance(self):
        known = [clearance for clearance in self.clearances if clearance.level != Clearance.INVALID]
        self.assertGreater(len(known), 100)
        self.assertGreaterEqual(min(clearance.minimum.lower_bound for clearance in known), self.stop_distance)

    def test_no_joint_is_faster_than_the_urdf_allows(self):
        self.assertEqual(joints_that_are_too_fast(self.states), {})

    def test_the_arms_came_so_close_that_they_were_held_back(self):
        distances = self.distances_of([state.position for state in self.states])
        self.assertLess(min(pair.distance for pair in distances), self.stop_distance + 0.01)


if __name__ == "__main__":
    rospy.init_node("avoiding_controller_test")
    rostest.rosrun("proximity_server", "avoiding_controller_test", AvoidingController, sys.argv)
