#!/usr/bin/env python3
"""What the example controller makes of the rows of one state, without a ROS master."""

import importlib.machinery
import importlib.util
import pathlib
import unittest

import numpy
import rosunit
from proximity_server.msg import ConstraintRows, ShapeRef

PROGRAM = pathlib.Path(__file__).resolve().parents[2] / "src/demo/avoiding_controller/avoiding_controller"
loader = importlib.machinery.SourceFileLoader("avoiding_controller", str(PROGRAM))
avoiding_controller = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
loader.exec_module(avoiding_controller)

STEP = 0.01  # [s]


def joint(name, limit, kind="revolute"):
    return f"<joint name='{name}' type='{kind}'><limit effort='1' {limit}/></joint>"


# The speeds are those of a UR5; the last two joints state none.
URDF = "<robot name='arm'>" + joint("lift", "lower='-6.28' upper='6.28' velocity='3.15'") + joint(
    "elbow", "lower='-3.14' upper='3.14' velocity='3.2'") + joint("slide", "lower='0' upper='1' velocity='0'", "prismatic") + \
    "<joint name='turn' type='continuous'/></robot>"


def rows(gradient, bound):
    """The message of one pair."""
    return ConstraintRows(joint_names=["turn", "slide", "elbow", "lift"], matrix=gradient[::-1], lower_bounds=[bound],
                          a=[ShapeRef(link="forearm")], b=[ShapeRef(link="wrist")], distances=[0.0194], unique=[True])


class Controller(unittest.TestCase):
    def setUp(self):
        self.joints = avoiding_controller.Joints(URDF)

    def controller(self, target, max_speed=0.5, allowance=0.02):
        return avoiding_controller.Controller(self.joints, numpy.array(target), STEP, max_speed, allowance)

    def test_speeds_that_the_urdf_does_not_state_have_no_limit(self):
        numpy.testing.assert_array_equal(self.joints.max_speeds, [3.15, 3.2, numpy.inf, numpy.inf])

    def test_no_joint_is_faster_than_the_urdf_says(self):
        velocity = self.controller([6.0, -3.0, 0.0, 6.0], max_speed=100.0).velocity(numpy.zeros(4), rows([0.0] * 4, -numpy.inf))
        numpy.testing.assert_allclose(velocity, [3.15, -3.2, 0.0, 12.0], atol=1e-9)

    # Regression: a pair that cannot part made a UR5 move at up to 97 rad/s, this way and that way.
    def test_a_pair_that_cannot_part_does_not_race(self):
        for side in (-1.0, 1.0):
            velocity = self.controller([0.0] * 4).velocity(numpy.zeros(4), rows([0.0, 0.0003 * side, 0.0, 0.0], 0.0275))
            self.assertLess(numpy.abs(velocity).max(), 0.05)

    def test_no_joint_is_beyond_its_position_after_a_step(self):
        positions = numpy.array([6.27, 0.0, 0.002, 0.0])
        velocity = self.controller([6.28, 0.0, 0.0, 0.0], max_speed=100.0).velocity(
            positions, rows([1.0, 0.0, -1.0, 0.0], 2.0))
        after = positions + STEP * velocity
        self.assertTrue((after >= self.joints.lower - 1e-12).all() and (after <= self.joints.upper + 1e-12).all(), after)

    def test_names_the_pairs_that_hold_it_back(self):
        controller = self.controller([1.0, 0.0, 0.0, 0.0])
        velocity = controller.velocity(numpy.zeros(4), rows([-1.0, 0.0, 0.0, 0.0], -0.02))
        self.assertTrue(controller.rests_early(numpy.zeros(4), velocity), velocity)
        self.assertEqual(controller.held_back_by, ["forearm - wrist (0.0194 m)"])
        controller = self.controller([1.0, 0.0, 0.0, 0.0])
        velocity = controller.velocity(numpy.zeros(4), rows([1.0, 0.0, 0.0, 0.0], -0.02))
        self.assertFalse(controller.rests_early(numpy.zeros(4), velocity))
        self.assertEqual(controller.held_back_by, [])

    # Regression: a forearm between two places trembled, and its distance shrank with each step.
    def test_a_pair_between_two_places_does_not_tremble(self):
        slope, farthest = 0.05, 0.0206  # the distance is farthest - slope |lift - 0.8 elbow|; the target is at a side
        controller, positions, turns, last = self.controller([3.0, 0.0, 0.0, 0.0]), numpy.array([-0.02, 0.0, 0.0, 0.0]), 0, 0.0
        for _ in range(500):
            side = -numpy.sign(positions[0] - 0.8 * positions[1]) or 1.0
            distance = farthest - slope * abs(positions[0] - 0.8 * positions[1])
            self.assertGreater(distance, 0.0195)
            message = rows([slope * side, -0.8 * slope * side, 0.0, 0.0], -0.5 * (distance - 0.02) / 0.08)
            message.distances = [distance]
            velocity = controller.velocity(positions, message)
            if abs(velocity[0]) > 0.005:
                turns += velocity[0] * last < 0.0
                last = velocity[0]
            positions = positions + STEP * velocity
        self.assertLess(turns, 10)  # with the present rows alone they are 206


class RememberedRows(unittest.TestCase):
    PAIR = ("forearm", "wrist")

    def setUp(self):
        self.remembered = avoiding_controller.RememberedRows()

    def also(self, gradient, distance=0.02, positions=(0.0, 0.0)):
        rows = {self.PAIR: (numpy.array(gradient), distance)}
        return [tuple(place) for pair, place in self.remembered.update(numpy.array(positions), rows) if pair == self.PAIR]

    # Regression: with one place more than the present one, a robot went to and fro between three.
    def test_all_places_that_are_equally_near_are_heeded(self):
        self.assertEqual([], self.also([0.1, 0.0]))
        self.assertEqual([(0.1, 0.0)], self.also([-0.1, 0.0]))
        self.assertEqual([(-0.1, 0.0), (0.1, 0.0)], self.also([0.0, 0.1]))
        self.assertEqual([(0.0, 0.1), (-0.1, 0.0)], self.also([0.1, 0.0]), "the present one is not remembered, too")

    # Regression: of a UR10, whose gradients differed by 16 % at one place and at the other.
    def test_places_are_told_apart_where_the_robot_hardly_moves(self):
        self.also([-0.053, -0.001, -0.002], positions=(0.0, 0.0, 0.0))
        self.assertEqual(1, len(self.also([-0.058, 0.004, 0.004], positions=(0.0, 2e-4, 3e-4))))

    def test_a_gradient_that_turns_with_the_robot_is_of_one_place(self):
        for i in range(50):
            angle = 0.005 * i
            self.assertEqual([], self.also([numpy.cos(10 * angle), numpy.sin(10 * angle)], positions=(angle, 0.0)))

    def test_a_place_that_is_farther_by_now_is_forgotten(self):
        self.also([1.0, 0.0])
        self.assertEqual(1, len(self.also([-1.0, 0.0])))
        self.assertEqual([], self.also([-1.0, 0.0], positions=(0.002, 0.0), distance=0.018))


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "controller_test", __name__)
