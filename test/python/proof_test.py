#!/usr/bin/env python3
"""Proofs about boxes of joint positions."""

import math
import unittest

import numpy

import cases
from cases import ARM_AND_BASE, TURN, balls, demo, proximity, random_states, repeats

PROVEN, REFUTED = (proximity.Outcome.PROVEN, proximity.Outcome.REFUTED) if proximity else (1, 2)


def apart(turn):
    """The distance of the balls of base and arm."""
    return math.sqrt(5.0 - 4.0 * math.cos(turn)) - 0.3


class OnPaper(unittest.TestCase):
    def test_a_pair_stays_apart_in_its_limits(self):
        rows, closest = balls(only_pairs=ARM_AND_BASE).prove([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.5)
        self.assertEqual((PROVEN, 0.0), (rows["outcome"][0], rows["undecided"][0]))
        self.assertLessEqual(rows["lower"][0], apart(0.0))
        self.assertGreater(rows["lower"][0], 0.5)
        self.assertEqual((1, 3), closest.shape)

    def test_a_pair_that_comes_to_the_distance_is_refuted_by_a_state(self):
        robot, distance = balls(only_pairs=ARM_AND_BASE), 0.8
        rows, closest = robot.prove([0.0, 0.0, 0.0], [3.0, 0.0, 0.0], distance)
        self.assertEqual(REFUTED, rows["outcome"][0])
        self.assertLessEqual(rows["upper"][0], distance)
        self.assertLessEqual(robot.minimum(closest[0])["lower"], distance)
        self.assertTrue(0.0 <= closest[0, TURN] <= 3.0)

    def test_objects_are_part_of_it(self):
        robot = balls(only_pairs=[]).with_object("post", proximity.Sphere(0.1), (0.0, 0.0, 9.0))
        rows, _ = robot.prove()
        self.assertEqual(len(robot.pairs), len(rows))
        self.assertEqual(list(range(len(rows))), list(rows["pair"]))


class BesideDistances(unittest.TestCase):
    def test_no_state_of_a_box_contradicts_a_proof(self):
        robot, width = demo(), 0.02
        for centre in random_states(robot, repeats(12), 31):
            rows, _ = robot.prove(centre - width, centre + width, boxes=300)
            states = centre + width * numpy.random.default_rng(32).choice([-1.0, 0.3, 1.0], size=(50, len(centre)))
            everything = robot.closest(states, len(rows))
            for pair, lower in zip(rows["pair"], rows["lower"]):
                self.assertGreaterEqual(everything["upper"][everything["pair"] == pair].min(), lower)

    def test_the_answer_does_not_depend_on_the_threads(self):
        robot, centre = demo(), random_states(demo(), 1, 33)[0]
        (rows, closest), (again, closest_again) = (one.prove(centre - 0.1, centre + 0.1, boxes=200)
                                                   for one in (robot, demo(threads=1)))
        self.assertEqual(rows.tobytes(), again.tobytes())
        self.assertEqual(closest.tobytes(), closest_again.tobytes())


if __name__ == "__main__":
    cases.main()
