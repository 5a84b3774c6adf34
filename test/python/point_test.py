#!/usr/bin/env python3
"""Points and rays: on paper, one among many, and what is refused."""

import csv
import io
import math
import os
import signal
import subprocess
import unittest

import numpy

import cases
from cases import BALLS, DEMO, IS_SANITIZED, TURN, UP, UP_TWICE, balls, demo, proximity, random_states, repeats
from proximity import Hit, Status

BASE, ARM, LAMP = 0, 1, 3  # of Robot.links of the balls; the carriage has no geometry
CLEARANCE = os.environ.get("CLEARANCE")  # the tool
RADII = {BASE: 0.1, ARM: 0.2, LAMP: 0.5}


def centres(q):
    """Of the three balls in one state."""
    turn, up, _ = q
    return {BASE: numpy.array([1.0, 0.0, 0.0]), ARM: 2.0 * numpy.array([math.cos(turn), math.sin(turn), 0.0]),
            LAMP: numpy.array([0.0, 0.0, 5.0 + 3.0 * up])}


def random_points(count, seed, reach=2.0):
    return numpy.random.default_rng(seed).uniform(-reach, reach, (count, 3))


def random_rays(count, seed):
    """From all around to near the robot."""
    random = numpy.random.default_rng(seed)
    origins = random.normal(size=(count, 3))
    origins *= 2.0 / numpy.linalg.norm(origins, axis=1)[:, None]
    return origins, random.uniform(-0.5, 0.5, (count, 3)) + [0.0, 0.0, 0.8] - origins


class PointsOnPaper(unittest.TestCase):
    def setUp(self):
        self.robot = balls()
        self.q = numpy.array([0.7, 0.4, 0.0])

    def test_the_distance_is_that_of_the_closest_centre_less_the_radius(self):
        points = random_points(500, 1, 6.0)
        rows = self.robot.point_distance(self.q, points)
        self.assertEqual((proximity.POINT, (500,)), (rows.dtype, rows.shape))
        for number, (point, row) in enumerate(zip(points, rows)):
            distances = {link: numpy.linalg.norm(point - centre) - RADII[link] for link, centre in centres(self.q).items()}
            link = min(distances, key=distances.get)
            self.assertEqual((0, number, link, Status.CONVERGED),
                             (row["state"], row["point"], row["link"], row["status"]))
            self.assertAlmostEqual(distances[link], row["distance"], delta=1e-12)
            self.assertTrue(row["lower"] <= distances[link] + 1e-12 and distances[link] <= row["upper"] + 1e-12)
            outwards = point - centres(self.q)[link]
            outwards /= numpy.linalg.norm(outwards)
            numpy.testing.assert_allclose(row["normal"], outwards, atol=1e-9)
            numpy.testing.assert_allclose(row["point_a"], centres(self.q)[link] + RADII[link] * outwards, atol=1e-9)
            numpy.testing.assert_allclose(row["point_b"], point, atol=1e-9)
        self.assertEqual({BASE, ARM, LAMP}, set(rows["link"].tolist()))

    def test_inside_it_is_negative_and_that_of_one_piece_is_the_depth(self):
        row = self.robot.point_distance(self.q, [1.0, 0.03, 0.0])
        self.assertAlmostEqual(-0.07, row["distance"], delta=1e-12)
        self.assertFalse(row["depth_is_lower_bound"])

    def test_the_radius_of_a_point_is_taken_off(self):
        points = [[1.0, 1.0, 0.0], [1.0, 2.0, 0.0]]
        robot = self.robot
        alone = robot.point_distance(self.q, points, links=["base"])["distance"]
        self.assertEqual((alone - 0.25).tolist(), robot.point_distance(self.q, points, 0.25, links=["base"])["distance"].tolist())
        several = robot.point_distance(self.q, points, [0.5, 0.0], links=["base"])
        numpy.testing.assert_allclose(several["distance"], [0.4, 1.9], atol=1e-12)
        numpy.testing.assert_allclose(several["point_b"], [[1.0, 0.5, 0.0], [1.0, 2.0, 0.0]], atol=1e-12)

    def test_only_the_named_links_and_objects_count(self):
        cell = self.robot.with_object("table", proximity.Box((1.0, 1.0, 0.2)), (0.0, 0.0, -1.0))
        cell = cell.with_object("cup", proximity.Sphere(0.1), (0.0, 0.0, 1.0), link="lamp")
        point = [0.0, 0.0, -0.8]
        self.assertEqual(BASE, cell.point_distance(self.q, point)["link"])  # a table stands around: it is no part of the robot
        names = [*cell.links, *cell.objects]
        for name, distance in {"table": 0.1, "cup": 7.9, "lamp": 6.5, "base": math.hypot(1.0, 0.8) - 0.1}.items():
            with self.subTest(name):
                row = cell.point_distance(self.q, point, links=[name])
                self.assertEqual(name, names[row["link"]])
                self.assertAlmostEqual(distance, row["distance"], delta=1e-12)
        self.assertEqual("cup", names[cell.point_distance(self.q, [0.0, 0.0, 7.5])["link"]])  # held objects count

    def test_beyond_a_threshold_a_bound_is_enough(self):
        points = random_points(500, 2, 6.0)
        exact, near = self.robot.point_distance(self.q, points), self.robot.point_distance(self.q, points, threshold=3.0)
        is_near = exact["distance"] <= 3.0
        self.assertTrue(20 < is_near.sum() < 480)
        self.assertEqual(exact[is_near].tobytes(), near[is_near].tobytes())
        far = near[~is_near]
        self.assertEqual(({Status.THRESHOLD}, {-1}), (set(far["status"]), set(far["link"])))
        self.assertTrue(((3.0 <= far["lower"]) & (far["lower"] <= exact["distance"][~is_near])).all())
        self.assertTrue(numpy.isnan(far["point_a"]).all())

    def test_gradients_are_in_the_columns_of_q(self):
        height = 5.0 + 3.0 * 0.4
        points = [[1.0, 3.0, 0.0], [0.0, 3.0, 1.0]]
        rows, gradients = self.robot.point_distance(self.q, points[:1], links=["arm"], gradient=True)
        self.assertEqual(((1,), (1, 3)), (rows.shape, gradients.shape))
        arm = centres(self.q)[ARM]
        moves = numpy.array([-arm[1], arm[0], 0.0])  # by the turn
        numpy.testing.assert_allclose(gradients[0, TURN], -rows["normal"][0] @ moves, atol=1e-12)
        self.assertEqual([0.0, 0.0], gradients[0, [UP, UP_TWICE]].tolist())
        row, gradient = self.robot.point_distance(self.q, points[1], links=["lamp"], gradient=True)
        numpy.testing.assert_allclose(gradient, [0.0, 3.0 * (height - 1.0) / math.hypot(3.0, height - 1.0), 0.0], atol=1e-12)
        rows, gradients = self.robot.point_distance(self.q, points, links=["lamp"], gradient=True, threshold=0.1)
        self.assertTrue(numpy.isnan(gradients).all())


class RaysOnPaper(unittest.TestCase):
    def setUp(self):
        self.robot = balls()
        self.q = numpy.array([0.0, 0.0, 0.0])  # the balls at 1 m and 2 m on the x axis, and the lamp at 5 m above

    def test_the_first_of_two_is_hit(self):
        row = self.robot.first_hit(self.q, [-1.0, 0.06, 0.0], [3.0, 0.0, 0.0])
        self.assertEqual((proximity.HIT, Hit.HIT, BASE), (row.dtype, row["hit"], row["link"]))
        self.assertAlmostEqual(2.0 - 0.08, row["distance"], delta=1e-8)
        self.assertTrue(row["distance"] - 1e-8 <= row["free_until"] <= row["distance"])
        numpy.testing.assert_allclose(row["point"], [0.92, 0.06, 0.0], atol=1e-8)
        numpy.testing.assert_allclose(row["normal"], [-0.8, 0.6, 0.0], atol=1e-6)
        self.assertEqual(ARM, self.robot.first_hit(self.q, [-1.0, 0.06, 0.0], [1.0, 0.0, 0.0], links=["arm", "lamp"])["link"])

    def test_a_ray_that_meets_nothing_within_its_range_is_free(self):
        rows = self.robot.first_hit(self.q, [-1.0, 0.0, 0.0], [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
                                    [1.8, 2.0, math.inf])
        self.assertEqual([Hit.FREE, Hit.HIT, Hit.FREE], rows["hit"].tolist())
        self.assertEqual([-1, BASE, -1], rows["link"].tolist())
        self.assertEqual([1.8, math.inf], rows["free_until"][[0, 2]].tolist())
        self.assertTrue(numpy.isnan(rows["distance"][[0, 2]]).all() and numpy.isnan(rows["point"][[0, 2]]).all())

    def test_a_ray_that_begins_inside_hits_there(self):
        row = self.robot.first_hit(self.q, [2.0, 0.1, 0.0], [1.0, 0.0, 0.0])
        self.assertEqual((Hit.HIT, ARM, 0.0, 0.0), (row["hit"], row["link"], row["distance"], row["free_until"]))

    def test_all_objects_count(self):
        cell = self.robot.with_object("wall", proximity.Box((0.2, 9.0, 9.0)), (-3.0, 0.0, 0.0))
        row = cell.first_hit(self.q, [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0])
        self.assertEqual("wall", [*cell.links, *cell.objects][row["link"]])
        self.assertAlmostEqual(2.9, row["distance"], delta=1e-8)

    def test_arrays_broadcast_as_those_of_a_sensor(self):
        directions = random_points(12, 3).reshape(3, 4, 3)
        rows = self.robot.first_hit(numpy.zeros((2, 3)), [0.0, 0.0, 1.0], directions, 7.0)
        self.assertEqual((2, 3, 4), rows.shape)
        self.assertEqual([*range(12)] * 2, rows["ray"].ravel().tolist())
        self.assertEqual([0] * 12 + [1] * 12, rows["state"].ravel().tolist())


class OneAmongMany(unittest.TestCase):
    """The robot of the demo, in more points than a part of a question has: kPart in src/python/questions.cpp."""

    @classmethod
    def setUpClass(cls):
        cls.robot = demo(threads=2).with_object("cup", proximity.Cylinder(0.04, 0.1), (0.1, 0.0, 0.0), link="left_hand",
                                                touch_links=["left_wrist"])
        cls.count = 1100 if IS_SANITIZED else 3000
        cls.q = random_states(cls.robot, (2, 3), 4)
        cls.points, cls.radii = random_points(cls.count, 5), numpy.random.default_rng(6).uniform(0.0, 0.1, cls.count)
        cls.origins, cls.directions = random_rays(cls.count, 7)

    def ask(self, q, which=slice(None)):
        """Rows and gradients of points, and rows of rays, without the numbers of states, points and rays."""
        rows, gradients = self.robot.point_distance(q, self.points[which], self.radii[which], gradient=True)
        hits = self.robot.first_hit(q, self.origins[which], self.directions[which])
        fields = [rows[name] for name in proximity.POINT.names if name not in ("state", "point")]
        return [*fields, gradients, *(hits[name] for name in proximity.HIT.names if name not in ("state", "ray"))]

    def assert_same(self, expected, found):
        for one, other in zip(expected, found):
            self.assertEqual(one.shape, other.shape)
            self.assertEqual(numpy.ascontiguousarray(one).tobytes(), numpy.ascontiguousarray(other).tobytes())

    def test_alone_in_any_order_and_in_any_number_of_threads_the_bits_are_the_same(self):
        together = self.ask(self.q[0, 0])
        self.assertTrue(0.05 * self.count < (together[-5] >= 0).sum())  # so many rays hit
        order = numpy.random.default_rng(8).permutation(self.count)
        self.assert_same([field[order] for field in together], self.ask(self.q[0, 0], order))
        for i in range(0, self.count, 50):
            self.assert_same([field[i:i + 1] for field in together], self.ask(self.q[0, 0], slice(i, i + 1)))
        self.addCleanup(setattr, self.robot, "threads", 2)
        for threads in (1, 7):
            self.robot.threads = threads
            self.assert_same(together, self.ask(self.q[0, 0]))

    def test_a_block_of_states_has_the_rows_of_each_state(self):
        block = self.ask(self.q)
        self.assertEqual((2, 3, self.count), block[0].shape)
        for place in numpy.ndindex(2, 3):
            self.assert_same([field[place] for field in block], self.ask(self.q[place]))
        self.assertEqual((2, 3, 0), self.robot.point_distance(self.q, numpy.zeros((0, 3))).shape)
        self.assertEqual((0, 5), self.robot.first_hit(self.q[:0, 0], self.origins[:5], [1.0, 0.0, 0.0]).shape)

    def test_a_hit_is_on_the_surface_and_what_is_free_of_the_robot(self):
        q = self.q[1, 1]
        hits = self.robot.first_hit(q, self.origins, self.directions)
        is_hit = hits["hit"] == Hit.HIT
        at_hits = self.robot.point_distance(q, hits["point"][is_hit])
        begins_outside = hits["distance"][is_hit] > 0.0
        self.assertLess(numpy.abs(at_hits["distance"][begins_outside]).max(), 1e-7)
        along = self.directions / numpy.linalg.norm(self.directions, axis=1)[:, None]
        until = numpy.where(is_hit, hits["free_until"], 4.0)[:, None]
        on_the_way = self.origins + numpy.random.default_rng(9).uniform(0.0, 0.999, (self.count, 1)) * until * along
        self.assertGreater(self.robot.point_distance(q, on_the_way)["upper"].min(), -1e-9)

    def test_gradients_are_those_of_differences(self):
        step, apart = 1e-6, 0.02
        joints = len(self.robot.joints)
        q = random_states(self.robot, repeats(30), 10)
        points = random_points(30, 11, 1.2)
        rows, gradients = self.robot.point_distance(q, points, gradient=True)
        steps = step * numpy.eye(joints)
        ahead = self.robot.point_distance(q[:, None] + steps, points)
        behind = self.robot.point_distance(q[:, None] - steps, points)
        differences = (ahead["distance"] - behind["distance"]).transpose(0, 2, 1) / (2 * step)
        same = ((ahead["link"] == rows["link"][:, None]) & (behind["link"] == rows["link"][:, None])).all(axis=1)
        smooth = same & rows["unique"] & (rows["distance"] > apart)
        self.assertGreater(smooth.mean(), 0.4)
        # As in gradient_test.py: the bending, and the accepted gap of two distances.
        self.assertLess(numpy.abs(gradients - differences)[smooth].max(), 1.5e-3)

    def test_a_state_that_is_not_finite_has_no_answer_and_spoils_no_other(self):
        q = self.q[0].copy()
        q[1, 2] = math.nan
        rows, gradients = self.robot.point_distance(q, self.points[:9], gradient=True)
        hits = self.robot.first_hit(q, self.origins[:9], self.directions[:9])
        self.assertEqual(({Status.UNKNOWN}, {Hit.UNKNOWN}, {-1}), (set(rows["status"][1]), set(hits["hit"][1]), set(rows["link"][1])))
        self.assertTrue(numpy.isnan(rows["distance"][1]).all() and numpy.isnan(gradients[1]).all())
        self.assertEqual((set(range(9)), {0.0}), (set(rows["point"][1]), set(hits["free_until"][1])))
        self.assertEqual(rows[[0, 2]].tobytes(), self.robot.point_distance(self.q[0], self.points[:9])[[0, 2]].tobytes())

    def test_when_time_is_over_nothing_is_known(self):
        rows = self.robot.point_distance(self.q, self.points, time_budget=0.0)
        hits = self.robot.first_hit(self.q, self.origins, self.directions, time_budget=0.0)
        self.assertEqual(({Status.UNKNOWN}, {Hit.UNKNOWN}), (set(rows["status"].ravel()), set(hits["hit"].ravel())))
        self.assertTrue(numpy.isnan(rows["distance"]).all() and (hits["free_until"] == 0.0).all())

    def test_a_signal_ends_a_long_question(self):
        class Interrupted(Exception):
            pass

        def interrupt(number, frame):
            raise Interrupted

        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, interrupt))
        q = random_states(self.robot, 2000, 12)
        with self.assertRaises(Interrupted):
            signal.setitimer(signal.ITIMER_REAL, 0.05)
            self.robot.point_distance(q, self.points, gradient=True)


@unittest.skipUnless(CLEARANCE, "the tool clearance is not built")
class BesideTheTool(cases.InFolder):
    """clearance --points prints the same numbers, to the last bit."""

    FIELDS = ("distance", "lower", "upper")
    VECTORS = ("point_a", "point_b", "normal")

    def setUp(self):
        super().setUp()
        self.robot = demo()
        self.q, self.points = random_states(self.robot, repeats(30), 15), random_points(2500, 16)
        self.radii = numpy.random.default_rng(17).uniform(0.0, 0.1, len(self.points))
        self.rows = self.robot.point_distance(self.q, self.points, self.radii)
        joints = [joint.name for joint in self.robot.joints]
        self.states, self.cloud = self.table("q.csv", joints, self.q), self.folder / "cloud.npy"
        numpy.save(self.cloud, numpy.column_stack([self.points, self.radii]))

    def table(self, name, header, numbers):
        rows = [header, *([repr(number) for number in row] for row in numbers.tolist())]
        return self.file(name, "".join(",".join(row) + "\n" for row in rows))

    def printed(self, points, *options):
        command = [CLEARANCE, DEMO / "robot.urdf", "--srdf", DEMO / "robot.srdf", "--states", self.states, "--points", points]
        return subprocess.run([*command, *options], text=True, check=True, capture_output=True,
                              env={**os.environ, "ROS_PACKAGE_PATH": ":".join(map(str, cases.package_roots()))}).stdout

    def assert_same(self, expected, text):
        found = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual(len(expected), len(found))
        for row, printed in zip(expected, found):
            self.assertEqual([row["state"], row["point"], self.robot.links[row["link"]]],
                             [int(printed["state"]), int(printed["point"]), printed["link_a"]])
            numbers = [*(row[name] for name in self.FIELDS), *(number for name in self.VECTORS for number in row[name])]
            columns = [*self.FIELDS, *(f"{name}_{axis}" for name in self.VECTORS for axis in "xyz")]
            self.assertEqual([float(number).hex() for number in numbers], [float(printed[name]).hex() for name in columns])

    def test_of_all_points(self):
        few = self.table("few.csv", ["x", "y", "z", "radius"], numpy.column_stack([self.points, self.radii])[:100])
        self.assert_same(self.rows[:, :100].ravel(), self.printed(few, "--pairs", "all"))

    def test_of_the_closest_point(self):
        closest = self.rows[numpy.arange(len(self.q)), self.rows["distance"].argmin(axis=1)]
        for threads in "12":
            self.assert_same(closest, self.printed(self.cloud, "--threads", threads))

    def test_of_those_below_a_distance(self):
        near = [rows[rows["lower"] <= 0.05] for rows in self.rows]
        self.assert_same(numpy.concatenate([rows[rows["distance"].argsort(kind="stable")] for rows in near]),
                         self.printed(self.cloud, "--pairs", "below:0.05"))


class Links(unittest.TestCase):
    Q = [0.0, 0.0, 0.0]

    def test_are_a_list_and_no_text(self):
        for ask in (lambda **links: balls().point_distance(self.Q, self.Q, **links),
                    lambda **links: balls().first_hit(self.Q, self.Q, [1.0, 0.0, 0.0], **links)):
            with self.assertRaisesRegex(TypeError, "incompatible function arguments"):
                ask(links="arm")

    def test_a_link_of_which_no_mesh_is_there_does_not_count(self):
        text = BALLS.replace('<sphere radius="0.5"/>', '<mesh filename="file:///nowhere.stl"/>')
        with cases.no_warnings():
            robot = proximity.Robot.from_text(text, allow_missing_meshes=True)
        self.assertEqual(BASE, robot.point_distance(self.Q, [1.0, 0.0, 1.0])["link"])
        self.assertEqual(Hit.FREE, robot.first_hit(self.Q, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0])["hit"])


if __name__ == "__main__":
    cases.main()
