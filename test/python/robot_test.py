#!/usr/bin/env python3
"""Making a robot, what it tells of itself, and what it refuses."""

import math
import multiprocessing
import pickle
import re
import unittest
import warnings

import numpy

import cases
from cases import (ARM_AND_BASE, BALLS, DEMO, SOURCE, InFolder, balls, demo, no_warnings, package_roots, panda, proximity,
                   random_states)

TRIANGLE = """solid s
facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet
endsolid s
"""
MESH = """<robot name="r"><link name="stone"><collision><geometry><mesh filename="{}"/></geometry></collision></link></robot>"""


class Properties(unittest.TestCase):
    def test_joints_are_named_in_the_order_of_the_columns_with_their_limits(self):
        robot = balls()
        self.assertEqual(["turn", "up", "up_twice"], [joint.name for joint in robot.joints])
        self.assertEqual(["revolute", "prismatic", "prismatic"], [joint.type for joint in robot.joints])
        self.assertEqual([(-2.0, 3.0), (0.0, 1.0), (0.0, 2.0)], [(joint.lower, joint.upper) for joint in robot.joints])
        self.assertEqual([None, None, "up"], [joint.mimic for joint in robot.joints])

    def test_a_joint_without_limits_has_infinite_ones(self):
        turning = BALLS.replace('type="revolute"', 'type="continuous"').replace('<limit lower="-2" upper="3"', "<limit")
        joint = balls_of(turning).joints[0]
        self.assertEqual(("continuous", -math.inf, math.inf), (joint.type, joint.lower, joint.upper))

    def test_ranges_are_those_that_are_sampled(self):
        turning = BALLS.replace('type="revolute"', 'type="continuous"')
        self.assertEqual([[-math.pi, math.pi], [0.0, 1.0], [0.0, 0.0]], balls_of(turning).ranges.tolist())

    def test_ranges_of_more_than_a_turn_are_one_turn_about_their_middle(self):
        wide = BALLS.replace('lower="-2" upper="3"', 'lower="-5" upper="7"')
        lower, upper = balls_of(wide).ranges[0]
        self.assertAlmostEqual(1.0 - math.pi, lower, delta=1e-15)
        self.assertAlmostEqual(1.0 + math.pi, upper, delta=1e-15)

    def test_the_robot_of_the_demo_warns_of_nothing(self):
        self.assertEqual([], demo().warnings)

    def test_pairs_are_those_that_are_checked_by_name(self):
        self.assertEqual([("base", "arm"), ("base", "lamp"), ("arm", "lamp")], balls().pairs)
        self.assertEqual(ARM_AND_BASE, balls(only_pairs=ARM_AND_BASE).pairs)

    def test_pairs_that_are_not_checked_have_a_reason(self):
        robot = balls(only_pairs=[], exclude_pairs=[("lamp", "base")])
        self.assertEqual([("arm", "lamp")], robot.pairs)
        self.assertEqual([("base", "arm"), ("base", "lamp")], [(a, b) for a, b, _ in robot.unchecked])
        self.assertNotEqual(robot.unchecked[0][2], robot.unchecked[1][2])
        self.assertTrue(all(reason for _, _, reason in robot.unchecked))

    def test_its_text_names_the_robot(self):
        self.assertEqual('<proximity.Robot "balls": 3 joints, 3 pairs>', repr(balls()))
        self.assertEqual("balls", balls().name)

    def test_the_module_has_the_version_of_the_package(self):
        manifest = (SOURCE / "package.xml").read_text()
        self.assertEqual(re.search("<version>(.*)</version>", manifest).group(1), proximity.__version__)

    def test_the_example_robots_have_pairs_and_joints(self):
        for make, joints, mimics in ((demo, 16, []), (panda, 9, ["panda_finger_joint2"])):
            with self.subTest(make.__name__):
                robot = make()
                self.assertEqual(joints, len(robot.joints))
                self.assertEqual(mimics, [joint.name for joint in robot.joints if joint.mimic])
                self.assertGreater(len(robot.pairs), 10)


def balls_of(urdf):
    return proximity.Robot.from_text(urdf, only_pairs=ARM_AND_BASE)


def minimum_of(robot):
    """What a process of a pool calls."""
    return robot.minimum([[0.1] * len(robot.joints)])["distance"][0]


class Pickles(unittest.TestCase):
    def test_a_robot_comes_back_as_it_was(self):
        with no_warnings():
            robots = [balls(srdf='<robot name="balls"><group name="lights"><joint name="up"/></group></robot>', group="lights",
                            exclude_pairs=[("arm", "lamp")], only_pairs=[], padding=0.01, threads=3, thresholds="stop_distance: 0.01"),
                      demo(mesh_tolerance=0.01)]
        for robot in robots:
            with self.subTest(robot.name), warnings.catch_warnings():
                warnings.simplefilter("error")  # they were told when it was made
                again = pickle.loads(pickle.dumps(robot))
                self.assertEqual((robot.pairs, robot.threads, robot.warnings, robot.name),
                                 (again.pairs, again.threads, again.warnings, again.name))
                q = random_states(robot, 20, 1)
                self.assertEqual(robot.minimum(q).tobytes(), again.minimum(q).tobytes())

    def test_objects_and_what_is_allowed_come_along(self):
        shapes = [proximity.Sphere(0.3), (proximity.Box((0.1, 0.2, 0.3)), (0.3, 0.2, 0.1)), proximity.Capsule(0.1, 0.7),
                  proximity.Cylinder(0.1, 0.3), proximity.Cone(0.1, 0.3), proximity.Ellipsoid((0.1, 0.2, 0.3)),
                  proximity.Boxes([[0, 0, 0]], [[0.1, 0.2, 0.3]]),
                  proximity.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])]
        robot = (balls().with_object("z", shapes, (3, 1, 0)).with_object("cup", proximity.Sphere(0.1), (0, 0, 1), link="arm")
                 .with_object("a", proximity.HalfSpace((0, 0.6, 0.8), -3.0), padding=0.01)
                 .with_object("shade", proximity.Sphere(0.2), (0, 0, 1), frame="lamp").moved("z", (4, 1, 0.5))
                 .detached("cup", (9, 9, 9)).attached("cup", "lamp", (0, 0, 1), touch_links=["arm"]).allowing("z", "lamp"))
        again = pickle.loads(pickle.dumps(robot))
        self.assertEqual(robot.pairs, again.pairs)
        self.assertEqual(repr(robot.objects), repr(again.objects))
        q = random_states(robot, 20, 1)
        expected, found = robot.closest(q, 9), again.closest(q, 9)
        self.assertEqual(expected["pair"].tolist(), found["pair"].tolist())
        numpy.testing.assert_allclose(found["distance"], expected["distance"], atol=2e-9)

    def test_the_processes_of_a_pool_take_it(self):
        robot = balls(threads=1).with_object("ball", proximity.Sphere(0.5), (0.0, 4.0, 0.0))
        if cases.IS_SANITIZED:
            self.skipTest("a child of an instrumented process would load the module without the runtime of the sanitizers")
        with multiprocessing.get_context("fork").Pool(2) as pool:
            self.assertEqual([minimum_of(robot)] * 3, pool.map(minimum_of, [robot] * 3))


class Loading(InFolder):
    def test_a_file_and_its_text_give_the_same_robot(self):
        of_file = demo()
        with no_warnings():
            of_text = proximity.Robot.from_text((DEMO / "robot.urdf").read_text(), (DEMO / "robot.srdf").read_text(),
                                                packages=package_roots())
        self.assertEqual(of_file.pairs, of_text.pairs)
        q = [0.1] * len(of_file.joints)
        self.assertEqual(of_file.closest(q, 103).tobytes(), of_text.closest(q, 103).tobytes())

    def test_paths_are_texts_or_path_objects(self):
        path = self.file("balls.urdf", BALLS)
        self.assertEqual(proximity.Robot(path).pairs, proximity.Robot(str(path)).pairs)

    def test_relative_meshes_begin_at_the_folder_of_the_urdf(self):
        self.file("stone.stl", TRIANGLE)
        with no_warnings():
            proximity.Robot(self.file("robot.urdf", MESH.format("stone.stl")))
            proximity.Robot.from_text(MESH.format("stone.stl"), folder=self.folder)

    def test_packages_are_looked_for_in_the_given_folders(self):
        (self.folder / "rocks").mkdir()
        self.file("rocks/package.xml", "<package><name>rocks</name></package>")
        self.file("rocks/stone.stl", TRIANGLE)
        with no_warnings():
            proximity.Robot.from_text(MESH.format("package://rocks/stone.stl"), packages=[self.folder])
            with self.assertRaisesRegex(ValueError, 'stone.*rocks'):
                proximity.Robot.from_text(MESH.format("package://rocks/stone.stl"), packages=[])

    def test_a_padding_is_taken_off_the_distance_once_for_each_of_the_two(self):
        q = [0.0, 0.0, 0.0]
        bare, padded = balls(only_pairs=ARM_AND_BASE), balls(only_pairs=ARM_AND_BASE, padding=0.01)
        self.assertAlmostEqual(0.7, bare.minimum(q)["distance"], delta=1e-12)
        self.assertAlmostEqual(0.68, padded.minimum(q)["distance"], delta=1e-12)

    def test_the_group_restricts_the_pairs(self):
        srdf = '<robot name="balls"><group name="lights"><joint name="up"/></group></robot>'
        self.assertEqual([("base", "lamp"), ("arm", "lamp")],
                         proximity.Robot.from_text(BALLS, srdf, group="lights", only_pairs=balls().pairs).pairs)

    def test_what_is_odd_is_a_warning_that_names_the_file(self):
        path = self.file("balls.urdf", BALLS)
        with self.assertWarnsRegex(UserWarning, "balls.urdf: .*moon"):
            robot = proximity.Robot(path, self.file("balls.srdf", '<robot name="balls"><disable_collisions link1="arm" '
                                                                  'link2="moon" reason="Never"/></robot>'))
        self.assertTrue(any("moon" in text for text in robot.warnings))

    def test_a_mesh_that_cannot_be_read_is_a_warning_if_allowed(self):
        with self.assertRaisesRegex(ValueError, r"absent.stl: cannot be read \(No such file or directory\)"):
            proximity.Robot.from_text(MESH.format("absent.stl"), folder=self.folder)
        with self.assertWarnsRegex(UserWarning, 'link "stone".*absent.stl'):
            proximity.Robot.from_text(MESH.format("absent.stl"), folder=self.folder, allow_missing_meshes=True)

    def test_a_mimic_that_makes_no_sense_is_a_warning_if_allowed(self):
        broken = BALLS.replace('mimic joint="up"', 'mimic joint="pu"')
        self.assertNotEqual(BALLS, broken)
        with self.assertRaisesRegex(ValueError, '"up_twice" mimics the unknown joint "pu".*allow_broken_mimics'):
            proximity.Robot.from_text(broken)
        with self.assertWarnsRegex(UserWarning, '"up_twice" mimics the unknown joint "pu".*a joint of its own'):
            robot = proximity.Robot.from_text(broken, allow_broken_mimics=True)
        self.assertIsNone(robot.joints[2].mimic)
        self.assertIsNone(pickle.loads(pickle.dumps(robot)).joints[2].mimic)

    def test_a_name_of_any_length_is_cut_in_errors(self):
        for name in ("x" * 5_000_000, "\u00e4" * 5_000_000, "x " * 5_000_000):
            with self.assertRaisesRegex(ValueError, "bytes left out") as caught:
                balls(group=name)
            self.assertLess(len(str(caught.exception)), 17000)

    def test_an_option_that_does_not_exist_is_refused(self):
        with self.assertRaises(TypeError):
            balls(tolerance=0.1)


if __name__ == "__main__":
    cases.main()
