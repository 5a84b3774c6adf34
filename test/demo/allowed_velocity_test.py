#!/usr/bin/env python3
"""The quadratic program of the example controller, without ROS."""

import pathlib
import sys
import unittest

import numpy
import rosunit

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "src/demo/avoiding_controller"))
from allowed_velocity import Infeasible, allowed_velocity  # noqa: E402

UNUSED = -numpy.inf
ROUNDING = 1e-9


class AllowedVelocity(unittest.TestCase):
    def assert_velocity(self, expected, wanted, matrix, lower_bounds):
        numpy.testing.assert_allclose(allowed_velocity(wanted, matrix, lower_bounds), expected, atol=ROUNDING)

    def test_a_velocity_that_keeps_all_constraints_is_taken_as_it_is(self):
        self.assert_velocity([0.3, -0.2], [0.3, -0.2], [[1.0, 0.0], [0.0, -1.0]], [-0.1, -0.1])

    def test_one_constraint_takes_off_what_is_against_it(self):
        self.assert_velocity([-0.1, 0.5], [-1.0, 0.5], [[1.0, 0.0]], [-0.1])

    def test_a_slanted_constraint_shortens_along_its_row(self):
        # (0, -1) is 1 / sqrt(2) beyond x + y >= 0, and the nearest point of that line is half of the way aside.
        self.assert_velocity([0.5, -0.5], [0.0, -1.0], [[3.0, 3.0]], [0.0])

    def test_two_constraints_meet_in_a_corner(self):
        self.assert_velocity([-0.1, -0.2], [-1.0, -1.0], [[1.0, 0.0], [0.0, 1.0]], [-0.1, -0.2])

    def test_a_positive_bound_makes_a_resting_robot_retreat(self):
        self.assert_velocity([0.0, 0.1], [0.0, 0.0], [[0.0, 2.0]], [0.2])

    def test_a_row_that_is_not_used_does_not_count(self):
        self.assert_velocity([-1.0, 0.0], [-1.0, 0.0], [[0.0, 0.0], [0.0, 0.0]], [UNUSED, UNUSED])

    def test_constraints_that_contradict_each_other_are_refused(self):
        with self.assertRaises(Infeasible):
            allowed_velocity([0.0, 0.0], [[1.0, 0.0], [-1.0, 0.0]], [0.1, 0.1])

    def test_a_bound_that_no_joint_can_change_is_refused(self):
        with self.assertRaises(Infeasible):
            allowed_velocity([1.0, 0.0], [[0.0, 0.0]], [0.1])

    def test_an_infinite_bound_is_refused(self):
        with self.assertRaises(Infeasible):
            allowed_velocity([1.0, 0.0], [[1.0, 0.0]], [numpy.inf])

    def test_numbers_that_are_nan_are_refused(self):
        for wanted, row, bound in ((numpy.nan, 1.0, 0.0), (0.0, numpy.nan, 0.0), (0.0, 1.0, numpy.nan)):
            with self.assertRaises(ValueError):
                allowed_velocity([wanted], [[row]], [bound])

    def test_no_allowed_velocity_is_nearer_in_random_programs(self):
        # The optimum is where the difference from the wanted velocity points into no allowed direction (Boyd, Vandenberghe,
        # Convex Optimization, 2004, 4.2.3): (x - wanted) . (z - x) >= 0 for every allowed z.
        chance = numpy.random.default_rng(1)
        bent = 0
        for _ in range(300):
            matrix = chance.normal(size=(8, 5))
            bounds = -chance.uniform(0.0, 0.5, size=8)
            wanted = chance.normal(size=5)
            nearest = allowed_velocity(wanted, matrix, bounds)
            self.assertLessEqual((bounds - matrix @ nearest).max(), ROUNDING)
            bent += numpy.linalg.norm(nearest - wanted) > 1e-3
            for direction in chance.normal(size=(30, 5)):
                # Rest is allowed, and so is what lies between it and the first constraint along the direction.
                rates = matrix @ direction
                reach = min((bound / rate for bound, rate in zip(bounds, rates) if rate < 0.0), default=1.0)
                other = chance.uniform() * min(reach, 10.0) * direction
                self.assertGreaterEqual((nearest - wanted) @ (other - nearest), -ROUNDING)
        self.assertGreater(bent, 200)


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "allowed_velocity_test", AllowedVelocity)
