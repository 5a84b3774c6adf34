#!/usr/bin/env python3
"""Derivatives of distances: on paper, and beside differences of distances."""

import math
import unittest

import numpy

import cases
from cases import ARM_AND_BASE, BALLS, IS_SANITIZED, UP_TWICE, UP, TURN, balls, demo, panda, proximity, random_states, repeats


class OnPaper(unittest.TestCase):
    def test_of_two_balls_in_a_plane(self):
        robot = balls(only_pairs=ARM_AND_BASE)
        turns = numpy.linspace(-2.0, 3.0, 501)
        rows, gradients = robot.gradient(numpy.stack([turns, 0 * turns, 0 * turns], axis=1))
        expected = 2.0 * numpy.sin(turns) / numpy.sqrt(5.0 - 4.0 * numpy.cos(turns))
        self.assertEqual((501, 3), gradients.shape)
        self.assertLess(numpy.abs(gradients[:, TURN] - expected).max(), 1e-12)
        self.assertFalse(gradients[:, [UP, UP_TWICE]].any())
        self.assertEqual(robot.minimum([0.5, 0.0, 0.0])["distance"], robot.gradient([0.5, 0.0, 0.0])[0]["distance"])

    def test_in_overlap_it_is_positive_where_the_depth_shrinks(self):
        robot = proximity.Robot.from_text(BALLS.replace('radius="0.2"', 'radius="2.5"'), only_pairs=ARM_AND_BASE)
        row, gradient = robot.gradient([math.pi / 2, 0.0, 0.0])
        self.assertLess(row["distance"], 0.0)
        self.assertAlmostEqual(2.0 / math.sqrt(5.0), gradient[TURN], delta=1e-12)

    def test_a_leader_has_the_part_of_the_joint_that_follows_it(self):
        robot = balls(only_pairs=[("base", "lamp")])
        row, gradient = robot.gradient([0.3, 0.25, 0.0])
        height = 5.75  # 5 + 3 * 0.25, so that it changes by 3 m/m
        numpy.testing.assert_allclose(gradient, [0.0, 3.0 * height / math.hypot(1.0, height), 0.0], atol=1e-12)

    def test_of_the_closest_pairs_each_row_has_its_own(self):
        robot = balls()
        q = [[0.3, 0.25, 0.0], [1.3, 0.5, 0.0]]
        rows, gradients = robot.gradient(q, 4)
        self.assertEqual(((2, 4), (2, 4, 3)), (rows.shape, gradients.shape))
        self.assertEqual(robot.closest(q, 4).tobytes(), rows.tobytes())
        self.assertTrue(numpy.isnan(gradients[:, 3]).all())
        for row, gradient in zip(rows[:, :3].ravel(), gradients[:, :3].reshape(-1, 3)):
            one, expected = balls(only_pairs=[robot.pairs[row["pair"]]]).gradient(q[row["state"]])
            self.assertEqual(one["distance"], row["distance"])
            self.assertEqual(expected.tolist(), gradient.tolist())

    def test_where_the_points_are_one_choice_of_many_the_row_says_so(self):
        # The ball is in the middle of the other one: every direction is as short.
        row, gradient = proximity.Robot.from_text(
            BALLS.replace('xyz="2 0 0"', 'xyz="1 0 0"'), only_pairs=ARM_AND_BASE).gradient([0.0, 0.0, 0.0])
        self.assertFalse(row["unique"])
        self.assertTrue(numpy.isfinite(gradient).all())

    def test_a_floating_joint_stays_where_it_is_and_has_nought(self):
        # To turn or move the joint would change the distance.
        floating = BALLS.replace('type="revolute"', 'type="floating"').replace('xyz="2 0 0"', 'xyz="2 1 0"')
        robot = proximity.Robot.from_text(floating, only_pairs=ARM_AND_BASE)
        row, gradient = robot.gradient([0.7, 0.0, 0.0])
        self.assertAlmostEqual(math.sqrt(2.0) - 0.3, row["distance"], delta=1e-12)
        self.assertEqual([0.0, 0.0, 0.0], gradient.tolist())


class BesideDifferences(unittest.TestCase):
    """Random states of whole robots, against central differences of distances.

    The distance of convex shapes that are apart bends by at most the square of the speed of the points, some m/rad, over the
    distance, so that over a step h on both sides it is off by no more than h / distance times that."""

    STEP = 1e-6  # [rad] or [m]
    APART = 0.02  # [m]
    # The bending 1e-6 * 3 ** 2 / 0.02 = 5e-4, and the accepted gap of two distances, 2 * 1e-9 / 2e-6 = 1e-3.
    ACCEPTED = 1.5e-3  # [m/rad] or [m/m]

    def assert_close(self, robot, states):
        count = len(robot.joints)
        q = random_states(robot, states, 7)
        rows, gradients = robot.gradient(q)
        steps = self.STEP * numpy.eye(count)
        ahead = robot.minimum((q[:, None] + steps).reshape(-1, count)).reshape(states, count)
        behind = robot.minimum((q[:, None] - steps).reshape(-1, count)).reshape(states, count)
        differences = (ahead["distance"] - behind["distance"]) / (2 * self.STEP)
        same_pair = ((ahead["pair"] == rows["pair"][:, None]) & (behind["pair"] == rows["pair"][:, None])).all(axis=1)
        smooth = same_pair & rows["unique"] & (rows["distance"] > self.APART)
        if not IS_SANITIZED:
            self.assertGreater(smooth.sum(), 0.4 * states)
            self.assertGreater(numpy.abs(gradients[smooth]).max(), 0.1)
        self.assertLess(numpy.abs(gradients - differences)[smooth].max(), self.ACCEPTED)

    def test_of_the_robot_of_the_demo(self):
        self.assert_close(demo(), repeats(500))

    def test_of_the_panda(self):
        self.assert_close(panda(), repeats(500))


if __name__ == "__main__":
    cases.main()
