#!/usr/bin/env python3
"""Distances that are guaranteed within an uncertainty."""

import math
import unittest

import numpy

import cases
from cases import ARM_AND_BASE, balls, demo, proximity, random_states, repeats


class OnPaper(unittest.TestCase):
    def test_without_uncertainty_it_is_the_lower_bound(self):
        robot = balls(only_pairs=ARM_AND_BASE)
        for nothing in (0, {}, "{}", {"joint_uncertainty": 0.0}):
            row, guaranteed = robot.guaranteed([1.0, 0.0, 0.0], nothing)
            self.assertIsInstance(guaranteed, float)
            self.assertEqual(row["lower"], guaranteed)

    def test_a_turn_loses_its_lever_along_the_normal(self):
        # At turn t the balls of base and arm are sqrt(5 - 4 cos t) - 0.3 apart.
        def apart(turn):
            return math.sqrt(5.0 - 4.0 * math.cos(turn)) - 0.3

        robot = balls(only_pairs=ARM_AND_BASE)
        row, guaranteed = robot.guaranteed([1.0, 0.0, 0.0], {"joint_uncertainty": {"*": 0.001}})
        self.assertAlmostEqual(apart(1.0), row["distance"], delta=1e-9)
        self.assertLessEqual(guaranteed, apart(0.999))
        self.assertAlmostEqual(apart(0.999), guaranteed, delta=1e-5)

    def test_the_pair_is_that_with_the_smallest_guaranteed_distance(self):
        robot = balls(only_pairs=[]).with_object("near", proximity.Sphere(0.1), (0.0, 0.0, 3.0))
        robot = robot.with_object("far", proximity.Sphere(0.1), (0.0, 0.0, -4.0))
        names = [robot.guaranteed([0.0, 0.0, 0.0], {"object_uncertainty": {"far": size}})[0]["pair"] for size in (0.0, 3.0)]
        self.assertNotEqual(names[0], names[1])
        self.assertIn("far", robot.pairs[names[1]])


class NotFinite(unittest.TestCase):
    def test_a_state_that_is_not_finite_has_no_answer(self):
        _, guaranteed = balls().guaranteed([[math.nan, 0.0, 0.0], [0.0, 0.0, 0.0]], 0.01)
        self.assertEqual([True, False], list(numpy.isnan(guaranteed)))


class BesideDistances(unittest.TestCase):
    def test_no_state_of_the_demo_within_the_uncertainty_is_closer(self):
        robot, width = demo(), 0.01
        q = random_states(robot, repeats(200), 21)
        rows, guaranteed = robot.guaranteed(q, width)
        numpy.testing.assert_array_less(guaranteed, rows["lower"])
        generator = numpy.random.default_rng(22)
        for _ in range(5):
            corners = q + width * generator.choice([-1.0, 1.0], size=q.shape)
            numpy.testing.assert_array_less(guaranteed, robot.minimum(corners)["upper"])


if __name__ == "__main__":
    cases.main()
