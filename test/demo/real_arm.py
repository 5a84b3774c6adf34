#!/usr/bin/env python3
"""The example controller drives an arm that has links nearer than the stop distance by design, without an SRDF: it moves, no joint
is faster than the URDF allows, and no pair comes nearer than the stop distance, or than it was at the start."""

import sys
import threading
import unittest

import numpy
import rospy
import rostest
from proximity_server.msg import ConstraintRows
from proximity_server.srv import QueryConfiguration, QueryConfigurationRequest
from sensor_msgs.msg import JointState
from urdf_speeds import joints_that_are_too_fast

NODE = "/proximity_server"
STEPS = 400
LOSS = 1e-4  # [m] what a step may lose before the rows make up for it


class RealArm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.wait_for_message(f"{NODE}/constraints", ConstraintRows, timeout=60.0)
        cls.states, enough = [], threading.Event()

        def add(state):
            cls.states.append(state)
            if len(cls.states) == STEPS:
                enough.set()

        subscriber = rospy.Subscriber("joint_states", JointState, add)
        if not enough.wait(60.0):
            raise AssertionError(f"within 60 s there are {len(cls.states)} states, not {STEPS}")
        subscriber.unregister()
        cls.names = cls.states[0].name
        start = rospy.get_param("/avoiding_controller/start")
        cls.positions = numpy.array([[start.get(name, 0.0) for name in cls.names]] + [state.position for state in cls.states])

    def distances(self):
        """{pair: its distance in each state}, of the pairs that are below the stop distance in one of them."""
        stop = rospy.get_param(f"{NODE}/stop_distance", 0.02)
        states = [JointState(name=self.names, position=position) for position in self.positions[::4]]
        query = rospy.ServiceProxy(f"{NODE}/query_configuration", QueryConfiguration)
        below = query(QueryConfigurationRequest(states=states, mode=QueryConfigurationRequest.BELOW_THRESHOLD, threshold=stop))
        self.assertTrue(below.success, below.status.message)
        pairs = sorted({(pair.a.link, pair.b.link) for state in below.states for pair in state.pairs})
        request = QueryConfigurationRequest(states=states, mode=QueryConfigurationRequest.PER_PAIR)
        for pair in pairs:
            for list_of, link in zip((request.a, request.b), pair):
                list_of.append(type(below.states[0].minimum.a)(link=link))
        each = query(request)
        self.assertTrue(each.success, each.status.message)
        return stop, {pair: numpy.array([state.pairs[i].distance for state in each.states]) for i, pair in enumerate(pairs)}

    def test_it_moves(self):
        self.assertGreater(numpy.linalg.norm(self.positions[-1] - self.positions[0]), 0.5)

    def test_no_joint_is_faster_than_the_urdf_allows(self):
        self.assertEqual(joints_that_are_too_fast(self.states), {})

    def test_no_pair_comes_nearer_than_the_stop_distance_or_the_start(self):
        stop, distances = self.distances()
        self.assertTrue(distances, "this robot was to have links that are near by design")
        lost = {pair: (min(stop, of_pair[0]) - of_pair).max() for pair, of_pair in distances.items()}
        self.assertLess(max(lost.values()), LOSS, lost)


if __name__ == "__main__":
    rospy.init_node("real_arm")
    rostest.rosrun("proximity_server", "real_arm", RealArm, sys.argv)
