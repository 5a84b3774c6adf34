#!/usr/bin/env python3
"""Motions that are proven to be free without a search."""

import math
import unittest

import numpy

import cases
from cases import ARM_AND_BASE, TURN, UP, UP_TWICE, balls, demo, proximity, random_states, repeats


class OnPaper(unittest.TestCase):
    """At turn t the balls of base and arm are sqrt(5 - 4 cos t) - 0.3 apart, and the ball on the arm ends 2.2 m from the axis."""

    def test_a_joint_alone_may_use_the_whole_distance(self):
        robot = balls(only_pairs=ARM_AND_BASE)
        turns = numpy.linspace(0.5, 3.0, 11)
        free = robot.free_motion(numpy.stack([turns, 0 * turns, 0 * turns], axis=1), 0.1, influence_distance=9.0)
        apart = numpy.sqrt(5.0 - 4.0 * numpy.cos(turns)) - 0.3
        numpy.testing.assert_allclose(free[:, TURN], (apart - 0.1) / 2.2, rtol=1e-9)
        self.assertTrue(numpy.isinf(free[:, UP]).all())
        self.assertFalse(free[:, UP_TWICE].any())

    def test_a_leader_has_the_part_of_the_joint_that_follows_it(self):
        free = balls(only_pairs=[("base", "lamp")]).free_motion([0.0, 0.0, 0.0], influence_distance=9.0)
        self.assertAlmostEqual((math.hypot(1.0, 5.0) - 0.6) / 3.0, free[UP], delta=1e-9)

    def test_a_motion_is_scaled_to_what_is_free(self):
        robot = balls(only_pairs=ARM_AND_BASE)
        q = [1.0, 0.0, 0.0]
        free = robot.free_motion(q)[TURN]
        scales = robot.free_scale(q, [[2.0 * free, 9.0, 9.0], [-4.0 * free, 0.0, 0.0], [0.5 * free, 0.0, 0.0]])
        numpy.testing.assert_allclose(scales, [0.5, 0.25, 1.0], rtol=1e-9)
        self.assertIsInstance(robot.free_scale(q, [1.0, 0.0, 0.0]), float)

    def test_below_the_distance_nothing_is_free(self):
        robot = balls(only_pairs=ARM_AND_BASE)
        self.assertEqual(0.0, robot.free_motion([0.1, 0.0, 0.0], 1.0)[TURN])
        self.assertEqual(0.0, robot.free_scale([0.1, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0))

    def test_an_object_that_a_link_carries_moves_with_it(self):
        robot = balls(only_pairs=[]).with_object("bob", proximity.Sphere(0.1), (3.0, 0.0, 0.0), frame="arm")
        robot = robot.with_object("post", proximity.Sphere(0.1), (0.0, 5.0, 0.0)).allowing("bob", "arm").allowing("post", "arm")
        free = robot.free_motion([0.0, 0.0, 0.0], influence_distance=9.0)[TURN]
        self.assertAlmostEqual(min((math.hypot(3.0, 5.0) - 0.2) / 3.1, (2.0 - 0.2) / 3.1), free, delta=1e-9)


class NotFinite(unittest.TestCase):
    def test_a_state_or_a_motion_that_is_not_finite_has_no_answer(self):
        robot = balls()
        self.assertTrue(numpy.isnan(robot.free_motion([math.nan, 0.0, 0.0])).all())
        scales = robot.free_scale([[0.0, 0.0, 0.0], [math.inf, 0.0, 0.0]], [[math.nan, 0.0, 0.0], [1.0, 0.0, 0.0]])
        self.assertTrue(numpy.isnan(scales).all())


class BesideDistances(unittest.TestCase):
    def test_no_pair_of_the_demo_comes_to_the_distance(self):
        robot, states, distance = demo(), repeats(300), 0.02
        q = random_states(robot, states, 11)
        q = q[robot.minimum(q)["lower"] > distance]
        self.assertGreater(len(q), 0)
        motions = numpy.random.default_rng(12).normal(size=q.shape)
        scales = robot.free_scale(q, motions, distance)
        self.assertTrue((scales > 0.0).all())
        for part in (0.25, 0.5, 1.0):
            self.assertGreater(robot.minimum(q + part * scales[:, None] * motions)["upper"].min(), distance)
        corners = motions * numpy.nan_to_num(robot.free_motion(q, distance), posinf=1.0) / numpy.abs(motions).sum(axis=1, keepdims=True)
        self.assertGreater(robot.minimum(q + corners)["upper"].min(), distance)


if __name__ == "__main__":
    cases.main()
