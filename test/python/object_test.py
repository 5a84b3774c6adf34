#!/usr/bin/env python3
"""Objects around a robot and in its hands: against distances on paper, and against the tool clearance."""

import csv
import io
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

import cases
from cases import ARM_AND_BASE, DEMO, InFolder, balls, demo, no_warnings, random_states, repeats, row_of
from proximity import Box, Boxes, Capsule, Cone, Cylinder, Ellipsoid, HalfSpace, Level, Mesh, MeshFile, Sphere, Verdict

AT_ZERO = [0.0, 0.0, 0.0]
CLEARANCE = os.environ.get("CLEARANCE")  # the tool

# A tetrahedron with a corner at the origin and edges of 1 m along the axes.
CORNERS = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def turned(angle, position=(0.0, 0.0, 0.0)):
    """A pose: a turn around z."""
    pose = numpy.eye(4)
    pose[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    pose[:3, 3] = position
    return pose


def names_of(robot, rows):
    return [robot.pairs[pair] for pair in rows["pair"].ravel()]


class OnPaper(unittest.TestCase):
    """The arm is a ball of radius 0.2 m on a circle of radius 2 m around z; base is one of 0.1 m at (1, 0, 0), which stands still."""

    def setUp(self):
        self.robot = balls(only_pairs=ARM_AND_BASE)

    def test_the_distance_from_a_ball_is_that_of_the_centres_less_the_radii(self):
        robot = self.robot.with_object("ball", Sphere(0.5), (0.0, 4.0, 1.0))
        self.assertEqual(("arm", "ball"), robot.pairs[1])
        turns = numpy.linspace(-2.0, 3.0, 301)
        rows = robot.closest(numpy.stack([turns, 0 * turns, 0 * turns], axis=1), 3)
        to_ball = numpy.linalg.norm(numpy.stack([2 * numpy.cos(turns), 2 * numpy.sin(turns) - 4, -1 + 0 * turns]), axis=0) - 0.7
        to_base = numpy.sqrt(5.0 - 4.0 * numpy.cos(turns)) - 0.3
        found = {pair: numpy.where(rows["pair"] == pair, rows["distance"], 0.0).sum(axis=1) for pair in (0, 1)}
        numpy.testing.assert_allclose(found[0], to_base, atol=1e-9)
        numpy.testing.assert_allclose(found[1], to_ball, atol=1e-9)
        numpy.testing.assert_allclose(robot.minimum([math.pi / 2, 0, 0])["normal"], [0, 2 / 5**0.5, 1 / 5**0.5], atol=1e-9)

    def test_each_shape_is_where_its_pose_says(self):
        # Each is at a distance of 1 m from the surface of the arm, which is at (2, 0, 0).
        shapes = {
            "sphere": (Sphere(0.3), (3.5, 0, 0)), "box": (Box((0.4, 2, 2)), (3.4, 0, 0)),
            "capsule": (Capsule(0.1, 0.6), (2, 0, 1.6)), "cylinder": (Cylinder(0.1, 0.6), (2, 0, 1.5)),
            "cone": (Cone(0.1, 0.6), (2, 0, -1.5)), "ellipsoid": (Ellipsoid((0.1, 0.2, 0.3)), (2, 1.4, 0)),
            "half-space": (HalfSpace((-1, 0, 0), -3.2), None),
            "boxes": (Boxes([[3.2, -1, -1], [9, 9, 9]], [[4, 1, 1], [10, 10, 10]]), None),
            "mesh": (Mesh(CORNERS, FACES), (3.2, -0.1, -0.1)),
        }
        for name, (shape, pose) in shapes.items():
            with self.subTest(name):
                robot = self.robot.with_object("thing", shape, pose)
                self.assertAlmostEqual(1.0, row_of(robot.closest(AT_ZERO, 2), 1)["distance"], delta=1e-9)
                # Among others it is the same: a list of shapes with their poses.
                together = self.robot.with_object("thing", [(Sphere(0.1), (50, 0, 0)), (shape, pose)])
                self.assertAlmostEqual(1.0, row_of(together.closest(AT_ZERO, 2), 1)["distance"], delta=1e-9)

    def test_points_are_an_object_of_their_voxels(self):
        wall = [[[3.2 + 1e-6, 0.01 * y, 0.01 * z] for y in range(-20, 20)] for z in range(-20, 20)]  # shape (40, 40, 3)
        nothing = [math.nan, 0.0, 0.0]
        robot = self.robot.with_points(numpy.array(wall + [[nothing] * 40]), resolution=0.05, name="wall")
        row = row_of(robot.closest(AT_ZERO, 2), 1)
        self.assertAlmostEqual(1.0, row["distance"], delta=1e-9)  # the voxels begin at 3.2
        for points, text in (([[1.0, 2.0]], "shape"), ([nothing], "none of its points is finite")):
            with self.assertRaisesRegex(ValueError, f'object "points": .*{text}'):
                self.robot.with_points(points)
        with self.assertRaisesRegex(ValueError, 'object "wall": there is one already'):
            robot.with_points(wall, name="wall")

    def test_a_mesh_of_a_file_and_its_arrays_are_the_same_object(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "corner.obj"
            path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) +
                            "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES))
            of_file = self.robot.with_object("corner", MeshFile(path, (2.0, 2.0, 2.0)), (3.0, -0.5, -0.5))
        of_arrays = self.robot.with_object("corner", Mesh(2.0 * numpy.array(CORNERS), FACES), (3.0, -0.5, -0.5))
        q = random_states(self.robot, 20, 1)
        self.assertEqual(of_arrays.closest(q, 2).tobytes(), of_file.closest(q, 2).tobytes())

    def test_an_object_moves_is_held_is_put_down_and_goes(self):
        quarter = [math.pi / 2, 0.0, 0.0]
        robot = self.robot.with_object("ball", Sphere(0.5), (0.0, 4.0, 0.0))
        self.assertAlmostEqual(1.3, robot.minimum(quarter)["distance"], delta=1e-9)
        moved = robot.moved("ball", (0.0, 5.0, 0.0))
        self.assertAlmostEqual(5**0.5 - 0.3, moved.minimum(quarter)["distance"], delta=1e-9)
        rows = moved.closest(quarter, 2)
        self.assertAlmostEqual(2.3, row_of(rows, 1)["distance"], delta=1e-9)

        held = robot.attached("ball", "arm", q=quarter)  # where it is: 2 m beyond the arm
        self.assertEqual([("base", "arm"), ("base", "ball"), ("lamp", "ball")], held.pairs)
        numpy.testing.assert_allclose(held.objects["ball"].pose[:3, 3], [4, 0, 0], atol=1e-12)
        for turn in (0.0, 1.0):
            rows = held.closest([turn, 0, 0], 2)
            centre = numpy.array([4 * math.cos(turn), 4 * math.sin(turn)])
            self.assertAlmostEqual(numpy.linalg.norm(centre - [1, 0]) - 0.6, row_of(rows, 1)["distance"], delta=1e-9)

        down = held.detached("ball", q=AT_ZERO)
        numpy.testing.assert_allclose(down.objects["ball"].pose[:3, 3], [4, 0, 0], atol=1e-12)
        self.assertEqual("", down.objects["ball"].link)
        rows = down.closest(quarter, 2)
        self.assertAlmostEqual(20**0.5 - 0.7, row_of(rows, 1)["distance"], delta=1e-9)

        self.assertEqual(self.robot.pairs, down.without("ball").pairs)
        # All of them are still there.
        self.assertEqual([{}, "", "arm", ""], [self.robot.objects, robot.objects["ball"].link, held.objects["ball"].link,
                                               down.objects["ball"].link])
        self.assertAlmostEqual(1.3, robot.minimum(quarter)["distance"], delta=1e-9)

    def test_an_object_that_moves_with_a_frame_is_checked_against_its_link(self):
        robot = balls(only_pairs=ARM_AND_BASE).with_object("lamp shade", Sphere(0.1), (0, 0, 1), frame="carriage")
        self.assertIn(("base", "lamp shade"), robot.pairs)
        for up in (0.0, 1.0):
            row = row_of(robot.closest([0.0, up, 0.0], 9), robot.pairs.index(("base", "lamp shade")))
            self.assertAlmostEqual(math.hypot(1.0, 1.0 + up) - 0.2, row["distance"], delta=1e-9)

    def test_padding_touch_links_and_allowed_pairs_count(self):
        ball = {"shapes": Sphere(0.5), "pose": (0.0, 4.0, 0.0)}
        padded = self.robot.with_object("ball", **ball, padding=0.1)
        self.assertAlmostEqual(1.2, padded.minimum([math.pi / 2, 0, 0])["distance"], delta=1e-9)
        held = self.robot.with_object("ball", Sphere(0.1), link="arm", touch_links=["base", "lamp"])
        self.assertEqual([("base", "arm")], held.pairs)
        allowed = self.robot.with_object("ball", **ball).allowing("lamp", "ball")
        self.assertEqual([("base", "arm"), ("arm", "ball")], allowed.pairs)

    def test_a_held_object_is_checked_against_others(self):
        robot = self.robot.with_object("wall", Box((1, 9, 9)), (4, 0, 0)).with_object("cup", Sphere(0.1), (0.5, 0, 0), link="arm")
        row = row_of(robot.closest(AT_ZERO, 9), robot.pairs.index(("wall", "cup")))
        self.assertAlmostEqual(3.5 - 0.6, row["distance"], delta=1e-9)
        self.assertAlmostEqual(1.0, row["normal"][0] * -1, delta=1e-9)

    def test_every_question_counts_objects(self):
        thresholds = "stop_distance: 0.1\nwarn_distance: 0.2\nobject_stop_distance: 0.1\nobject_warn_distance: 1.5"
        robot = balls(only_pairs=ARM_AND_BASE, thresholds=thresholds).with_object("ball", Sphere(0.5), (0.0, 4.0, 0.0))
        q = [math.pi / 2, 0.0, 0.0]  # the ball is at 1.3 m, the base at sqrt(5) - 0.3
        row = robot.level(q)
        self.assertEqual((("arm", "ball"), Level.WARN), (robot.pairs[row["pair"]], row["level"]))
        self.assertEqual((Verdict.BELOW, 1), tuple(robot.below(q, 1.31)))
        self.assertEqual((Verdict.ABOVE, -1), tuple(robot.below(q, 1.29)))
        self.assertEqual([("arm", "ball")], names_of(robot, robot.pairs_below(q, 1.31)))
        row, gradient = robot.gradient([1.0, 0.0, 0.0])
        self.assertEqual(("base", "arm"), robot.pairs[row["pair"]])
        rows, gradients = robot.gradient([1.0, 0.0, 0.0], 2)
        way = math.hypot(2 * math.cos(1), 2 * math.sin(1) - 4)
        self.assertAlmostEqual(-8 * math.cos(1) / way, gradients[rows["pair"] == 1][0][0], delta=1e-9)

    def test_states_without_an_answer_have_none_among_objects(self):
        robot = self.robot.with_object("ball", Sphere(0.5), (0.0, 4.0, 0.0))
        q = [AT_ZERO, [math.nan, 0, 0], [1.0, 0, 0]]
        self.assertEqual([1, 0, 1], robot.minimum(q)["status"].tolist())
        self.assertEqual([Verdict.ABOVE, Verdict.UNKNOWN, Verdict.ABOVE], robot.below(q, 0.1)["verdict"].tolist())
        listed = robot.pairs_below(q, 2.5)  # of state 0 the base is at 0.7 m, and the ball at sqrt(20) - 0.7
        self.assertEqual([(0, 0), (1, -1), (2, 0), (2, 1)], sorted(listed[["state", "pair"]].tolist()))
        self.assertTrue(numpy.isnan(robot.gradient(q)[1][1]).all())
        with self.assertRaisesRegex(ValueError, "distance"):
            robot.below(q, math.nan)


@unittest.skipUnless(CLEARANCE, "the tool clearance is not built")
class BesideTheTool(unittest.TestCase):
    CELL = """
objects:
- id: table
  pose: {position: [0.6, 0, 0.7], rpy: [0, 0, 0.3]}
  padding: 0.01
  primitives: [{type: BOX, dimensions: [0.5, 1.2, 0.05]}, {type: CYLINDER, dimensions: [0.7, 0.04]}]
  primitive_poses: [{}, {position: [0, 0, -0.35]}]
- id: cup
  link: left_hand
  touch_links: [left_wrist]
  pose: {position: [0.1, 0, 0]}
  primitives: [{type: CONE, dimensions: [0.1, 0.04]}, {type: SPHERE, dimensions: [0.03]}]
- id: lamp
  frame: head
  pose: {position: [0.3, 0, 0.2]}
  boxes: [{centres: [[0, 0, 0], [0.1, 0, 0]], sizes: [[0.05, 0.05, 0.05]]}]
- {id: floor, planes: [{coef: [0, 0, 1, 0.1]}]}
- id: corner
  pose: {position: [-0.6, 0.2, 0.9]}
  meshes: [{vertices: [[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0], [0, 0, 0.3]],
    triangles: [{vertex_indices: [0, 2, 1]}, {vertex_indices: [0, 1, 3]}, {vertex_indices: [0, 3, 2]}, {vertex_indices: [1, 2, 3]}]}]
rules:
- {a: table, b: torso, allowed: true}
"""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name) / "cell.yaml"
        cls.path.write_text(cls.CELL)
        cls.robot = demo()
        cls.of_file = cls.robot.with_objects(cls.path)
        with no_warnings():
            cls.by_hand = (
                cls.robot.with_object("table", [Box((0.5, 1.2, 0.05)), (Cylinder(0.04, 0.7), (0, 0, -0.35))],
                                      turned(0.3, (0.6, 0, 0.7)), padding=0.01)
                .with_object("cup", [Cone(0.04, 0.1), Sphere(0.03)], (0.1, 0, 0), link="left_hand", touch_links=["left_wrist"])
                .with_object("lamp", Boxes([[-0.025] * 3, [0.075, -0.025, -0.025]], [[0.025] * 3, [0.125, 0.025, 0.025]]),
                             (0.3, 0, 0.2), frame="head")
                .with_object("floor", HalfSpace((0, 0, 1), -0.1))
                .with_object("corner", Mesh(0.3 * numpy.array(CORNERS), FACES), (-0.6, 0.2, 0.9))
                .allowing("table", "torso"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def rows_of_tool(self, q, *options):
        states = io.StringIO()
        writer = csv.writer(states)
        writer.writerow([joint.name for joint in self.robot.joints])
        writer.writerows([repr(position) for position in state] for state in q.tolist())
        printed = subprocess.run([CLEARANCE, DEMO / "robot.urdf", "--srdf", DEMO / "robot.srdf", *options], input=states.getvalue(),
                                 text=True, check=True, capture_output=True,
                                 env={**os.environ, "ROS_PACKAGE_PATH": ":".join(map(str, cases.package_roots()))}).stdout
        return list(csv.DictReader(io.StringIO(printed)))

    def test_the_closest_pair_and_its_distance_are_those_that_the_tool_prints(self):
        q = random_states(self.robot, max(20, repeats(600)), 2)
        expected = self.rows_of_tool(q, "--objects", self.path)
        for name, robot in (("of the file", self.of_file), ("by hand", self.by_hand)):
            with self.subTest(name):
                rows = robot.minimum(q)
                self.assertEqual([(row["link_a"], row["link_b"]) for row in expected],
                                 [names if tuple(names) == (row["link_a"], row["link_b"]) else (names[1], names[0])
                                  for names, row in zip(names_of(robot, rows), expected)])
                distances = numpy.array([float(row["distance"]) for row in expected])
                self.assertLess(numpy.abs(rows["distance"] - distances).max(), 2e-9)
        objects = numpy.mean([not set(names) <= set(self.robot.links) for names in names_of(self.of_file, rows)])
        if not cases.IS_SANITIZED:
            self.assertTrue(0.2 < objects < 0.99, objects)

    def test_pairs_are_those_that_the_tool_checks(self):
        rows = self.rows_of_tool(numpy.zeros((1, len(self.robot.joints))), "--objects", self.path, "--pairs", "all")
        listed = {frozenset((row["link_a"], row["link_b"])) for row in rows}
        self.assertEqual(listed, set(map(frozenset, self.of_file.pairs)))
        self.assertEqual(self.of_file.pairs, self.by_hand.pairs)
        self.assertEqual(len(listed), len(self.of_file.pairs))

    def test_an_answer_depends_on_its_state_alone(self):
        q = random_states(self.robot, repeats(300), 6)
        order = numpy.random.default_rng(7).permutation(len(q))
        robot = self.of_file
        for name, ask in {"minimum": lambda q: robot.minimum(q), "closest": lambda q: robot.closest(q, 3),
                          "below": lambda q: robot.below(q, 0.05), "gradient": lambda q: robot.gradient(q)[1]}.items():
            with self.subTest(name):
                whole, shuffled = ask(q), ask(q[order])
                for field in whole.dtype.names or [...]:
                    if field != "state":
                        self.assertEqual(whole[field][order].tobytes(), shuffled[field].tobytes(), field)

    def test_a_description_of_an_object_makes_it_again(self):
        again = self.robot
        for name, thing in self.of_file.objects.items():
            again = again.with_object(name, thing.shapes, thing.pose, link=thing.link, touch_links=thing.touch_links,
                                      frame=thing.frame, padding=thing.padding)
        again = again.allowing("torso", "table")
        q = random_states(self.robot, 30, 4)
        numpy.testing.assert_allclose(self.of_file.closest(q, 4)["distance"], again.closest(q, 4)["distance"], atol=2e-9)
        self.assertEqual(("left_hand", ("left_wrist",), "head", 0.01),
                         (again.objects["cup"].link, again.objects["cup"].touch_links, again.objects["lamp"].frame,
                          again.objects["table"].padding))


class Files(InFolder):
    def setUp(self):
        super().setUp()
        self.robot = balls()

    def test_of_two_objects_of_a_file_with_one_id_the_second_counts(self):
        sphere = "{id: pin, pose: {position: {y: 4}}, primitives: [{type: SPHERE, dimensions: [%s]}]}"
        twice = self.robot.with_objects(self.file("cell.yaml", f"objects: [{sphere % 0.25}, {sphere % 0.5}]"))
        once = self.robot.with_object("pin", Sphere(0.5), (0.0, 4.0, 0.0))
        quarter = [math.pi / 2, 0.0, 0.0]
        self.assertEqual(once.minimum(quarter)["distance"], twice.minimum(quarter)["distance"])

    def test_an_rpy_of_a_file_that_looks_like_degrees_is_a_warning(self):
        turned = "objects: [{id: pin, pose: {rpy: [0, 90, 0]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}]"
        with self.assertWarnsRegex(UserWarning, r'rpy\[1\]: 90 rad is more than a turn'):
            self.robot.with_objects(self.file("cell.yaml", turned))


if __name__ == "__main__":
    cases.main()
