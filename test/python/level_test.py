#!/usr/bin/env python3
"""Levels by thresholds of pairs, links and groups, held against all pairs."""

import math
import pathlib
import pickle
import tempfile
import unittest

import numpy

import cases
from cases import BALLS, balls, demo, proximity, random_states, repeats
from proximity import Level, Status

# Two pairs of the demo's robot with thresholds of their own; a link before a group.
FILE = """
stop_distance: 0.03
warn_distance: 0.08
pair_stop_distance: [{links: [torso, left_upper_arm], distance: 0.01}, {links: [torso, right_upper_arm], distance: 0.1}]
pair_warn_distance: [{links: [torso, left_upper_arm], distance: 0.02}, {links: [right_upper_arm, torso], distance: 0.15}]
link_warn_distance: {head: 0.12}
"""


def thresholds_of(robot):
    """The stop and the warn distance of each pair of FILE."""
    stop, warn = numpy.full(len(robot.pairs), 0.03), numpy.full(len(robot.pairs), 0.08)
    for number, names in enumerate(robot.pairs):
        if "head" in names:
            warn[number] = 0.12
        if set(names) == {"torso", "left_upper_arm"}:
            stop[number], warn[number] = 0.01, 0.02
        if set(names) == {"torso", "right_upper_arm"}:
            stop[number], warn[number] = 0.1, 0.15
    return stop, warn


def levels_of(rows, stop, warn):
    """The level of each row by its bound."""
    lower = rows["lower"]
    return numpy.select([lower <= 0.0, lower <= stop[rows["pair"]], lower <= warn[rows["pair"]]],
                        [Level.COLLISION, Level.STOP, Level.WARN], Level.CLEAR)


class OfTheDemo(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        path = pathlib.Path(cls.folder.name) / "thresholds.yaml"
        path.write_text(FILE)
        cls.plain, cls.robot = demo(), demo(thresholds=path)
        cls.stop, cls.warn = thresholds_of(cls.robot)
        cls.q = random_states(cls.robot, repeats(1500), 5)
        cls.all = cls.plain.closest(cls.q, len(cls.plain.pairs))  # of each state

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_rows_have_the_level_of_their_pair_and_are_the_same_otherwise(self):
        for name, ask in (("minimum", lambda robot: robot.minimum(self.q)), ("closest", lambda robot: robot.closest(self.q, 4)),
                          ("pairs_below", lambda robot: robot.pairs_below(self.q, 0.11)),
                          ("gradient", lambda robot: robot.gradient(self.q[:50])[0])):
            with self.subTest(name):
                rows, plain = ask(self.robot), ask(self.plain)
                self.assertEqual((proximity.LEVELED_PAIR, proximity.PAIR), (rows.dtype, plain.dtype))
                numpy.testing.assert_array_equal(levels_of(plain, self.stop, self.warn), rows["level"])
                for field in plain.dtype.names:
                    self.assertEqual(plain[field].tobytes(), rows[field].tobytes(), field)

    def test_level_is_the_pair_with_the_worst_level_and_of_these_that_with_the_smallest_difference(self):
        found = self.robot.level(self.q)
        levels = levels_of(self.all, self.stop, self.warn)
        threshold = numpy.choose(levels, [self.warn[self.all["pair"]], self.warn[self.all["pair"]],
                                          self.stop[self.all["pair"]], 0.0 * self.all["distance"]])
        excess = numpy.where(levels == levels.max(axis=1, keepdims=True), self.all["distance"] - threshold, math.inf)
        place = excess.argmin(axis=1)
        numpy.testing.assert_array_equal(levels.max(axis=1), found["level"])
        expected = numpy.take_along_axis(self.all, place[:, None], axis=1)[:, 0]
        for field in ("pair", "distance", "lower", "upper", "point_a", "normal", "state"):
            numpy.testing.assert_array_equal(expected[field], found[field])
        # It is not always the closest pair, and every level is there.
        self.assertGreater((found["pair"] != self.all["pair"][:, 0]).mean(), 0.05)
        self.assertEqual(set(Level) - {Level.INVALID}, set(found["level"]))

    def test_threads_do_not_matter(self):
        before = self.robot.level(self.q).tobytes()
        self.addCleanup(setattr, self.robot, "threads", self.robot.threads)
        self.robot.threads = 3
        self.assertEqual(before, self.robot.level(self.q).tobytes())


class OnPaper(unittest.TestCase):
    """Base and arm are 0.7 m apart at 0, base and lamp sqrt(26) - 0.6 = 4.499 m, arm and lamp sqrt(29) - 0.7 = 4.685 m."""

    def test_the_pair_that_sets_the_level_need_not_be_the_closest(self):
        robot = balls(thresholds="pair_warn_distance: [{links: [lamp, arm], distance: 4.7}]")
        row = robot.level([0.0, 0.0, 0.0])
        self.assertEqual(("arm", "lamp", Level.WARN), (*robot.pairs[row["pair"]], row["level"]))
        self.assertAlmostEqual(math.sqrt(29.0) - 0.7, row["distance"], delta=1e-12)
        closest = robot.minimum([0.0, 0.0, 0.0])
        self.assertEqual(("base", "arm", Level.CLEAR), (*robot.pairs[closest["pair"]], closest["level"]))

    def test_a_clear_state_names_the_pair_that_is_nearest_to_its_warn_distance(self):
        robot = balls(thresholds="link_warn_distance: {lamp: 4}")
        row = robot.level([[0.0, 0.0, 0.0]])[0]
        self.assertEqual(("base", "lamp", Level.CLEAR), (*robot.pairs[row["pair"]], row["level"]))

    def test_a_group_is_one_of_the_srdf(self):
        srdf = '<robot name="balls"><group name="lights"><joint name="up"/></group></robot>'
        robot = balls(srdf=srdf, thresholds="group_warn_distance: {lights: 4.5}\ngroup_stop_distance: {lights: 4.4}")
        row = robot.level([0.0, 0.0, 0.0])
        self.assertEqual(("base", "lamp", Level.WARN), (*robot.pairs[row["pair"]], row["level"]))

    def test_a_state_without_an_answer_is_invalid(self):
        robot = balls(thresholds="stop_distance: 0")
        rows = robot.level([[math.nan, 0.0, 0.0], [0.0, 0.0, 0.0]])
        self.assertEqual([Level.INVALID, Level.CLEAR], list(rows["level"]))
        self.assertEqual(Status.UNKNOWN, rows["status"][0])
        self.assertEqual([Level.INVALID], list(robot.pairs_below([[math.nan, 0.0, 0.0]], 1.0)["level"]))
        self.assertEqual([Level.CLEAR] * 3 + [Level.INVALID], list(robot.closest([0.0, 0.0, 0.0], 4)["level"]))

    def test_a_file_with_nothing_in_it_means_the_defaults(self):
        self.assertEqual(Level.CLEAR, balls(thresholds="{}").level([0.0, 0.0, 0.0])["level"])


class OfAConfiguration(unittest.TestCase):
    """What the node's own parameters say; base and arm are 0.7 m apart at 0."""

    Q = [0.0, 0.0, 0.0]

    def test_padding_pairs_and_levels_count_and_arguments_are_stronger(self):
        text = "default_padding: 0.05\nwarn_distance: 0.61\nonly_pairs: [[base, arm]]\nmesh_tolerance: 0.001"
        robot = balls(config=text, only_pairs=[])
        self.assertEqual([("base", "arm")], robot.pairs)
        row = robot.level(self.Q)
        self.assertAlmostEqual(0.6, row["distance"], delta=1e-12)
        self.assertEqual(Level.WARN, row["level"])
        self.assertEqual(Level.CLEAR, balls(config=text, padding=0.0).level(self.Q)["level"])
        self.assertEqual(Level.STOP, balls(config=text, thresholds="stop_distance: 0.6001\nwarn_distance: 1")
                         .level(self.Q)["level"])

    def test_visuals_count_by_link_and_by_group(self):
        seen = BALLS.replace('<link name="arm"><collision>', '<link name="arm"><visual>').replace(
            '<sphere radius="0.2"/></geometry></collision>', '<sphere radius="0.2"/></geometry></visual>')
        srdf = '<robot name="balls"><group name="limb"><joint name="turn"/></group></robot>'
        pairs = [("base", "arm"), ("base", "lamp"), ("arm", "lamp")]
        with self.assertWarnsRegex(UserWarning, "1 of 1 links with a <visual>: arm. The parameter collision_from_visual"):
            self.assertEqual([("base", "lamp")], proximity.Robot.from_text(seen, srdf, only_pairs=pairs).pairs)
        for names in ("all", "[arm]", "[limb]"):
            with cases.no_warnings():
                robot = proximity.Robot.from_text(seen, srdf, only_pairs=pairs, config="collision_from_visual: " + names)
            self.assertEqual(balls().minimum(self.Q)["distance"], robot.minimum(self.Q)["distance"])
        with self.assertRaisesRegex(ValueError, 'the SRDF has no group "limp" .did you mean "limb"'):
            proximity.Robot.from_text(seen, srdf, config="collision_from_visual: [limp]")

    def test_objects_stand_there_and_survive_a_pickle(self):
        text = ("check_free_objects: true\n"
                "objects: [{id: ball, pose: {position: [0, 0, 9]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}]")
        robot = balls(config=text)
        self.assertEqual(["ball"], list(robot.objects))
        copy = pickle.loads(pickle.dumps(robot))
        self.assertEqual(["ball"], list(copy.objects))
        self.assertEqual(robot.level(self.Q).tobytes(), copy.level(self.Q).tobytes())


if __name__ == "__main__":
    cases.main()
