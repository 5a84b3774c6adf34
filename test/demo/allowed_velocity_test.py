#!/usr/bin/env python3
"""The quadratic programs of the example controller, without ROS."""

import pathlib
import sys
import unittest

import numpy
import rosunit

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "src/demo/avoiding_controller"))
from allowed_velocity import SLACK, Infeasible, allowed_velocity, nearest_velocity, yielding_velocity  # noqa: E402

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

    def test_only_rows_that_hold_back_push(self):
        velocity, pushes = nearest_velocity([-1.0, 0.0], [[2.0, 0.0], [0.0, 1.0]], [-0.4, -1.0])
        numpy.testing.assert_allclose(velocity, [-0.2, 0.0], atol=ROUNDING)
        numpy.testing.assert_allclose(pushes, [0.4, 0.0], atol=ROUNDING)  # (-1, 0) + 0.4 * (2, 0)


class YieldingVelocity(unittest.TestCase):
    def velocity(self, wanted, matrix, lower_bounds, limit=numpy.inf):
        limits = numpy.full(len(wanted), limit)
        return yielding_velocity(wanted, matrix, lower_bounds, -limits, limits)[0]

    def test_nothing_approaches_faster_than_its_row_allows(self):
        numpy.testing.assert_allclose(self.velocity([-1.0, 0.5], [[1.0, 0.0]], [-0.1]), [-0.1, 0.5], atol=ROUNDING)
        self.assertGreaterEqual(self.velocity([-1.0, 0.5], [[0.001, 0.0]], [0.1])[0], -ROUNDING)

    def test_a_pair_parts_at_the_speed_of_damped_least_squares(self):
        for norm in (1e-6, 0.006, SLACK, 0.5):
            expected = 0.05 * norm / (norm**2 + SLACK**2)
            numpy.testing.assert_allclose(self.velocity([0.0, 0.0], [[0.0, norm]], [0.05]), [0.0, expected], atol=ROUNDING)

    # Regression: "the constraints contradict each other", and the robot rested for ever.
    def test_two_rows_that_ask_for_the_contrary_meet_in_the_middle(self):
        velocity = self.velocity([0.3, 0.2], [[1.0, 0.0], [-1.0, 0.0]], [0.1, 0.1])
        numpy.testing.assert_allclose(velocity, [0.0, 0.2], atol=ROUNDING)

    def test_a_bound_that_no_joint_can_change_changes_nothing(self):
        numpy.testing.assert_allclose(self.velocity([0.3, 0.2], [[0.0, 0.0]], [0.1]), [0.3, 0.2], atol=ROUNDING)

    def test_no_joint_is_faster_than_its_limit(self):
        numpy.testing.assert_allclose(self.velocity([3.0, 0.0], [[1.0, 1.0]], [-1.0], limit=2.0), [2.0, 0.0], atol=ROUNDING)
        numpy.testing.assert_allclose(self.velocity([0.0, 0.0], [[0.0, SLACK]], [4.0], limit=2.0), [0.0, 2.0], atol=ROUNDING)

    def test_a_limit_goes_before_a_pair_that_shall_part(self):
        limits = numpy.array([1.0, 1.0])
        velocity, pushes = yielding_velocity([0.0, 0.0], [[0.5, 0.0]], [0.1], -limits, [0.0, 1.0])
        numpy.testing.assert_allclose(velocity, [0.0, 0.0], atol=ROUNDING)
        self.assertGreater(pushes[0], 0.0)


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "allowed_velocity_test", __name__)
