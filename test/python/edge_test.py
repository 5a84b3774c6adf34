#!/usr/bin/env python3
"""Edges, the straight ways between two states, and poses of links: on paper, and against samples."""

import math
import unittest

import numpy

import cases
from cases import ARM_AND_BASE, balls, demo, panda, proximity, random_states, repeats
from proximity import Box, Sphere, Status


class OnPaper(unittest.TestCase):
    """The arm turns towards the base, which it meets where 5 - 4 cos(turn) is 0.3 ** 2: nowhere. At 0 they are 0.7 m apart."""

    def setUp(self):
        self.robot = balls(only_pairs=ARM_AND_BASE)

    def test_the_first_contact_is_where_the_distance_is_reached(self):
        row = self.robot.first_contact([2.0, 0, 0], [-2.0, 0, 0], 1.0)
        turn = math.acos((5.0 - 1.3**2) / 4.0)  # where the distance is 1 m
        self.assertTrue(row["contact"])
        self.assertEqual((Status.CONVERGED, 0, ("base", "arm")), (row["status"], row["edge"], self.robot.pairs[row["pair"]]))
        self.assertAlmostEqual((2.0 - turn) / 4.0, row["t_contact"], delta=1e-6)
        self.assertTrue((2.0 - turn) / 4.0 - 1e-6 < row["t_free"] <= (2.0 - turn) / 4.0 + 1e-12)
        self.assertAlmostEqual(1.0, row["distance"], delta=2e-6)
        numpy.testing.assert_allclose(row["point_b"] - row["point_a"], row["distance"] * row["normal"], atol=1e-9)

    def test_without_a_contact_the_way_is_free(self):
        row = self.robot.first_contact([2.0, 0, 0], [-2.0, 0, 0], 0.69)
        self.assertEqual((False, Status.CONVERGED, 1.0, -1), (row["contact"], row["status"], row["t_free"], row["pair"]))
        self.assertTrue(math.isnan(row["t_contact"]))

    def test_the_minimum_is_that_of_the_whole_way(self):
        row = self.robot.minimum_between([2.0, 0, 0], [-1.0, 0, 0])
        self.assertTrue(row["lower"] <= 0.7 + 1e-12 and 0.7 - 1e-12 <= row["upper"] <= row["lower"] + 1e-6)
        self.assertAlmostEqual(2.0 / 3.0, row["time"], delta=1e-3)
        wide = self.robot.minimum_between([2.0, 0, 0], [-1.0, 0, 0], tolerance=0.1)
        self.assertTrue(wide["lower"] <= 0.7 <= wide["upper"] <= wide["lower"] + 0.1)

    def test_a_held_object_goes_along(self):
        # A ball beyond the arm, at 4 m, goes from 2 rad to 0 and meets the post there.
        robot = (self.robot.with_object("post", Box((0.2, 0.2, 3.0)), (4.0, 0.0, 0.0))
                 .with_object("ball", Sphere(0.3), (4.0, 0.0, 0.0), link="arm"))
        row = robot.first_contact([2.0, 0, 0], [0.0, 0, 0])
        self.assertEqual({"post", "ball"}, set(robot.pairs[row["pair"]]))
        # The centre of the ball is then 0.4 m from the middle of the post, in the direction of y, but for what the circle bends.
        self.assertAlmostEqual(1.0 - math.asin(0.4 / 4.0) / 2.0, row["t_contact"], delta=1e-3)
        self.assertTrue(robot.first_contact([2.0, 0, 0], [0.5, 0, 0])["t_free"] == 1.0)
        moving = self.robot.with_object("ball", Sphere(0.3), (3.0, 0.0, 0.0), frame="carriage")
        row = moving.minimum_between([0.0, 0.5, 0], [0.0, -0.5, 0])
        self.assertAlmostEqual(0.5, row["lower"], delta=1e-6)

    def test_many_edges_have_the_shape_to_which_starts_and_goals_broadcast(self):
        starts, goals = random_states(self.robot, 3, 1), random_states(self.robot, 4, 2)
        rows = self.robot.minimum_between(starts[:, None], goals)
        self.assertEqual((3, 4), rows.shape)
        self.assertEqual(numpy.arange(12).tolist(), rows["edge"].ravel().tolist())
        self.assertEqual(proximity.EDGE_MINIMUM, rows.dtype)
        self.assertEqual(proximity.CONTACT, self.robot.first_contact(starts[0], goals, 1.0).dtype)
        for i in range(3):
            for j in range(4):
                self.assertEqual(self.robot.minimum_between(starts[i], goals[j])["upper"], rows[i, j]["upper"])
        self.assertEqual((0,), self.robot.first_contact(starts[:0], goals[0]).shape)

    def test_what_is_not_finite_has_no_answer(self):
        rows = self.robot.first_contact([[math.nan, 0, 0], [0, 0, 0]], [1.0, 0, 0], 0.1)
        self.assertEqual([Status.UNKNOWN, Status.CONVERGED], rows["status"].tolist())
        self.assertEqual([0.0, 1.0], rows["t_free"].tolist())
        row = self.robot.minimum_between([math.nan, 0, 0], [1.0, 0, 0])
        self.assertEqual((Status.UNKNOWN, -math.inf), (row["status"], row["lower"]))


class Splines(unittest.TestCase):
    """The arm of OnPaper. With velocities of -v and v by second it swings out and back within 2 s: 2 - v t + v t^2 / 2, at most v / 2."""

    SWING = dict(velocities=([-2.0, 0, 0], [2.0, 0, 0]), duration=2.0)

    def setUp(self):
        self.robot = balls(only_pairs=ARM_AND_BASE)

    @staticmethod
    def distance(turn):
        return math.sqrt(5.0 - 4.0 * math.cos(turn)) - 0.3

    def test_a_cubic_swings_out_where_the_straight_way_rests(self):
        row = self.robot.minimum_between([2.0, 0, 0], [2.0, 0, 0], **self.SWING)
        self.assertTrue(row["lower"] <= self.distance(1.0) + 1e-12 and self.distance(1.0) - 1e-12 <= row["upper"] <= row["lower"] + 1e-6)
        self.assertAlmostEqual(0.5, row["time"], delta=2e-3)
        self.assertAlmostEqual(self.distance(2.0), self.robot.minimum_between([2.0, 0, 0], [2.0, 0, 0])["lower"], delta=1e-6)

    def test_the_first_contact_of_a_cubic_is_where_the_distance_is_reached(self):
        row = self.robot.first_contact([2.0, 0, 0], [2.0, 0, 0], self.distance(1.5), **self.SWING)
        time = (1.0 - math.sqrt(0.5)) / 2.0
        self.assertTrue(row["contact"])
        self.assertAlmostEqual(time, row["t_contact"], delta=1e-5)
        self.assertLessEqual(row["t_free"], time + 1e-12)
        nearest = self.robot.first_contact([2.0, 0, 0], [2.0, 0, 0], self.distance(0.99), **self.SWING)
        self.assertEqual((False, 1.0), (nearest["contact"], nearest["t_free"]))

    def test_a_quintic_takes_the_accelerations(self):
        # From rest at 2 rad with -1 rad/s^2 all the way: 2 - t^2 / 2, at 1 rad after sqrt(2) s.
        end = math.sqrt(2.0)
        row = self.robot.first_contact([2.0, 0, 0], [1.0, 0, 0], self.distance(1.5), velocities=([0.0, 0, 0], [-end, 0, 0]),
                                       accelerations=([-1.0, 0, 0], [-1.0, 0, 0]), duration=end)
        self.assertAlmostEqual(1.0 / end, row["t_contact"], delta=1e-5)

    def test_a_tracking_error_is_taken_off(self):
        row = self.robot.minimum_between([2.0, 0, 0], [1.5, 0, 0], tracking_error=[0.1, 0.0, 0.0])
        self.assertLessEqual(row["lower"], self.distance(1.4) + 1e-12)
        self.assertGreater(row["lower"], self.distance(1.5) - 0.1 * 2.3)  # the far side of the arm is 2.3 m from the axis
        self.assertAlmostEqual(self.distance(1.4), row["upper"], delta=1e-6)
        contact = self.robot.first_contact([2.0, 0, 0], [1.0, 0, 0], self.distance(1.5), tracking_error=0.1)
        self.assertLessEqual(contact["t_free"], 0.4 + 1e-12)

    def test_duration_and_velocities_are_those_of_each_edge(self):
        start, goal = [2.0, 0, 0], [[2.0, 0, 0], [2.0, 0, 0]]
        rows = self.robot.minimum_between(start, goal, velocities=([-2.0, 0, 0], [[2.0, 0, 0], [2.0, 0, 0]]), duration=[2.0, 1.0])
        self.assertEqual((2,), rows.shape)
        self.assertAlmostEqual(self.distance(1.0), rows["lower"][0], delta=1e-6)
        self.assertAlmostEqual(self.distance(1.5), rows["lower"][1], delta=1e-6)

    def test_what_is_not_finite_has_no_answer_and_a_tube_of_nought_is_the_way(self):
        def ask(**keywords):
            return self.robot.minimum_between([2.0, 0, 0], [1.0, 0, 0], **keywords)

        zero = [0.0, 0, 0]
        self.assertEqual(Status.UNKNOWN, ask(velocities=([math.nan, 0, 0], zero))["status"])
        self.assertEqual(ask(tracking_error=0.0).tobytes(), ask().tobytes())


class BesideSamples(unittest.TestCase):
    """Random edges of whole robots, each sampled: a sample lies never below what is proven, and what was found is there."""

    SAMPLES = 200
    TOLERANCE = 1e-4  # [m]

    def assert_holds(self, robot, edges):
        start = random_states(robot, 20 * edges, 3)
        start = start[robot.minimum(start)["lower"] > 0.06][:edges]
        self.assertEqual(edges, len(start))
        goal = start + 0.8 * (random_states(robot, edges, 4) - start)
        times = numpy.linspace(0.0, 1.0, self.SAMPLES)[:, None]
        samples = robot.minimum(start[:, None] + times * (goal - start)[:, None])
        self.assertEqual((edges, self.SAMPLES), samples.shape)

        minima = robot.minimum_between(start, goal, tolerance=self.TOLERANCE)
        self.assertTrue((minima["lower"] <= samples["upper"].min(axis=1) + 1e-9).all())
        at_minimum = robot.minimum(start + minima["time"][:, None] * (goal - start))
        self.assertTrue((numpy.abs(at_minimum["distance"] - minima["upper"]) < self.TOLERANCE).all())
        converged = minima["status"] == Status.CONVERGED
        self.assertTrue((minima["upper"] - minima["lower"])[converged].max() <= self.TOLERANCE)
        self.assertGreater(converged.mean(), 0.9)

        distance = 0.05
        contacts = robot.first_contact(start, goal, distance, tolerance=self.TOLERANCE)
        is_before = times[:, 0] < contacts["t_free"][:, None]
        self.assertTrue((samples["upper"][is_before] > distance).all())
        touching = contacts["contact"]
        at_contact = robot.minimum((start + contacts["t_contact"][:, None] * (goal - start))[touching])
        self.assertTrue((at_contact["distance"] <= distance + self.TOLERANCE + 1e-9).all())
        self.assertTrue((contacts["t_free"] <= contacts["t_contact"])[touching].all())
        self.assertTrue((contacts["t_free"][~touching & (contacts["status"] == Status.CONVERGED)] == 1.0).all())
        if not cases.IS_SANITIZED:
            later = contacts["t_contact"] > 0.0
            self.assertGreater(later.sum(), 0.05 * edges)
            self.assertGreater((~touching).sum(), 0.05 * edges)

    def test_of_the_robot_of_the_demo(self):
        self.assert_holds(demo(), max(10, repeats(300)))

    def test_of_the_panda_among_objects(self):
        robot = (panda().with_object("table", Box((0.6, 1.0, 0.05)), (0.6, 0.0, 0.2))
                 .with_object("tool", Box((0.04, 0.04, 0.3)), (0.0, 0.0, 0.2), link="panda_hand",
                              touch_links=["panda_leftfinger", "panda_rightfinger", "panda_link7"]))
        self.assert_holds(robot, max(10, repeats(150)))

    def test_threads_do_not_matter(self):
        robot = demo(threads=1)
        start, goal = random_states(robot, 40, 5), random_states(robot, 40, 6)
        before = [robot.first_contact(start, goal).tobytes(), robot.minimum_between(start, goal, tolerance=1e-3).tobytes()]
        robot.threads = 3
        self.assertEqual(before, [robot.first_contact(start, goal).tobytes(),
                                  robot.minimum_between(start, goal, tolerance=1e-3).tobytes()])


class Poses(unittest.TestCase):
    def test_of_each_link_in_the_frame_of_the_root(self):
        robot = balls()
        self.assertEqual(["base", "arm", "carriage", "lamp"], robot.links)
        q = [[0.3, 0.25, 9.0], [1.0, 0.5, 0.0]]
        poses = robot.link_poses(q)
        self.assertEqual((2, 4, 4, 4), poses.shape)
        for (turn, up, _), pose in zip(q, poses):
            numpy.testing.assert_array_equal(numpy.eye(4), pose[0])
            cosine, sine = math.cos(turn), math.sin(turn)
            numpy.testing.assert_allclose(pose[1], [[cosine, -sine, 0, 0], [sine, cosine, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
                                          atol=1e-15)
            self.assertAlmostEqual(5.0 + 3.0 * up, pose[3][2, 3])  # the lift, and what follows it twice as far
        self.assertEqual(poses[0].tobytes(), robot.link_poses(q[0]).tobytes())
        self.assertEqual((1, 2, 1, 4, 4, 4), robot.link_poses(numpy.zeros((1, 2, 1, 3))).shape)

    def test_an_object_that_is_put_where_a_link_is_touches_it(self):
        robot = demo()
        q = random_states(robot, 1, 7)[0]
        hand = robot.link_poses(q)[robot.links.index("left_hand")]
        cell = robot.with_object("ball", Sphere(0.001), hand)
        row = cell.pairs_below(q, 0.0)
        self.assertIn(("left_hand", "ball"), [cell.pairs[pair] for pair in row["pair"]])

    def test_a_state_that_is_not_finite_has_none(self):
        poses = balls().link_poses([[math.nan, 0, 0], [0, 0, 0]])
        self.assertTrue(numpy.isnan(poses[0]).all())
        self.assertTrue(numpy.isfinite(poses[1]).all())


if __name__ == "__main__":
    cases.main()
