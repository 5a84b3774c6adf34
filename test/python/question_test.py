#!/usr/bin/env python3
"""Questions about many states: their answers, what q may be, threads."""

import io
import math
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy

import cases
from cases import (ANSWERS, ARM_AND_BASE, DEMO, IS_SANITIZED, PANDA, balls, demo, package_roots, panda, proximity, random_states,
                   repeats)
from proximity import Status, Verdict


def answers(robot, q, distance=0.1, k=3):
    """Everything that a robot says of its states, as bytes."""
    return [numpy.asarray(answer).tobytes() for answer in (
        robot.minimum(q), robot.minimum(q, accuracy=1e-4), robot.closest(q, k), robot.below(q, distance), robot.pairs_below(q, distance),
        *robot.gradient(q, k), *robot.guaranteed(q, 0.002), robot.free_motion(q), robot.free_scale(q, numpy.full(numpy.shape(q), 1e-3)))]


class OnPaper(unittest.TestCase):
    """Two balls of radii 0.1 m and 0.2 m, on circles of radii 1 m and 2 m."""

    def setUp(self):
        self.robot = balls(only_pairs=ARM_AND_BASE)

    def test_the_distance_is_that_of_the_centres_less_the_radii(self):
        turns = numpy.linspace(-2.0, 3.0, 1001)
        answer = self.robot.minimum(numpy.stack([turns, 0 * turns, 0 * turns], axis=1))
        expected = numpy.sqrt(5.0 - 4.0 * numpy.cos(turns)) - 0.3
        self.assertLess(numpy.abs(answer["distance"] - expected).max(), 1e-12)
        self.assertTrue((answer["lower"] <= expected + 1e-12).all() and (expected <= answer["upper"] + 1e-12).all())
        self.assertTrue((answer["status"] == Status.CONVERGED).all())
        self.assertTrue((answer["state"] == numpy.arange(1001)).all())

    def test_points_and_normal_are_in_the_frame_of_the_root_from_the_first_link_to_the_second(self):
        answer = self.robot.minimum([math.pi / 2, 0.0, 0.0])
        towards = numpy.array([-1.0, 2.0, 0.0]) / math.sqrt(5.0)
        self.assertEqual(("base", "arm"), self.robot.pairs[answer["pair"]])
        numpy.testing.assert_allclose(answer["normal"], towards, atol=1e-12)
        numpy.testing.assert_allclose(answer["point_a"], numpy.array([1.0, 0.0, 0.0]) + 0.1 * towards, atol=1e-12)
        numpy.testing.assert_allclose(answer["point_b"], numpy.array([0.0, 2.0, 0.0]) - 0.2 * towards, atol=1e-12)

    def test_an_overlap_is_negative(self):
        large = cases.BALLS.replace('radius="0.2"', 'radius="1.5"')
        robot = proximity.Robot.from_text(large, only_pairs=ARM_AND_BASE)
        self.assertAlmostEqual(-0.6, robot.minimum([0.0, 0.0, 0.0])["distance"], delta=1e-12)

    def test_bounds_within_an_accuracy_hold_the_distance(self):
        turns = numpy.linspace(-2.0, 3.0, 1001)
        q = numpy.stack([turns, 0 * turns, 0 * turns], axis=1)
        expected = numpy.sqrt(5.0 - 4.0 * numpy.cos(turns)) - 0.3
        for accuracy in (0.1, 1e-4, 1e-8):
            with self.subTest(accuracy=accuracy):
                answer = self.robot.minimum(q, accuracy=accuracy)
                self.assertTrue((answer["lower"] <= expected + 1e-12).all() and (expected <= answer["upper"] + 1e-12).all())
                self.assertLessEqual((answer["upper"] - answer["lower"]).max(), accuracy + 1e-12)
                self.assertTrue((answer["status"] == Status.THRESHOLD).all())
                self.assertTrue((answer["distance"] == answer["lower"]).all())

    def test_below_tells_the_sides_of_a_distance(self):
        q = numpy.array([[0.0, 0.0, 0.0], [math.pi, 0.0, 0.0]])  # 0.7 m and 2.7 m
        answer = self.robot.below(q, 1.0)
        self.assertEqual([Verdict.BELOW, Verdict.ABOVE], answer["verdict"].tolist())
        self.assertEqual([0, -1], answer["pair"].tolist())

    def test_a_mimic_joint_follows_its_leader_whatever_its_own_column_says(self):
        robot = balls(only_pairs=[("base", "lamp")])
        height = 5.0 + 3.0 * 0.25  # the offset, the lift, and what follows it twice as far
        for own in (0.0, 1.0, -7.0):
            with self.subTest(own=own):
                answer = robot.minimum([0.0, 0.25, own])
                self.assertAlmostEqual(math.hypot(1.0, height) - 0.6, answer["distance"], delta=1e-12)

    def test_closest_and_pairs_below_are_sorted_by_distance(self):
        robot = balls()
        q = [[0.0, 0.0, 0.0], [math.pi, 0.5, 0.0]]
        closest = robot.closest(q, 3)
        self.assertEqual((2, 3), closest.shape)
        self.assertTrue((numpy.diff(closest["distance"], axis=1) > 0).all())
        self.assertEqual([[0, 0, 0], [1, 1, 1]], closest["state"].tolist())
        listed = robot.pairs_below(q, 5.0)
        near = closest[closest["distance"] <= 5.0]
        self.assertEqual(4, len(near))
        self.assertEqual(near[["state", "pair"]].tolist(), listed[["state", "pair"]].tolist())


class Shapes(unittest.TestCase):
    def setUp(self):
        self.robot = balls()

    def test_many_states_have_a_row_each(self):
        q = random_states(self.robot, 5, 1)
        self.assertEqual((5,), self.robot.minimum(q).shape)
        self.assertEqual((5, 2), self.robot.closest(q, 2).shape)
        self.assertEqual((5,), self.robot.below(q, 1.0).shape)
        self.assertEqual(proximity.PAIR, self.robot.minimum(q).dtype)
        self.assertEqual(proximity.VERDICT, self.robot.below(q, 1.0).dtype)

    def test_one_state_has_one_dimension_less(self):
        q = random_states(self.robot, 1, 1)
        self.assertEqual(self.robot.minimum(q)[0].tobytes(), self.robot.minimum(q[0]).tobytes())
        self.assertEqual(self.robot.closest(q, 2)[0].tobytes(), self.robot.closest(q[0], 2).tobytes())
        self.assertEqual(self.robot.below(q, 1.0)[0].tobytes(), self.robot.below(q[0], 1.0).tobytes())
        self.assertEqual(self.robot.pairs_below(q, 9.0).tobytes(), self.robot.pairs_below(q[0], 9.0).tobytes())
        self.assertIsInstance(float(self.robot.minimum(q[0])["distance"]), float)

    def test_more_dimensions_are_those_of_the_answer(self):
        q = random_states(self.robot, 24, 1)
        grid = q.reshape(2, 3, 4, 3)
        self.assertEqual((2, 3, 4), self.robot.minimum(grid).shape)
        self.assertEqual((2, 3, 4, 2), self.robot.closest(grid, 2).shape)
        self.assertEqual((2, 3, 4, 2, 3), self.robot.gradient(grid, 2)[1].shape)
        self.assertEqual((2, 0, 4), self.robot.below(numpy.zeros((2, 0, 4, 3)), 1.0).shape)
        self.assertEqual((2, 1, 2), self.robot.minimum(q[:4].reshape(2, 1, 2, 3).tolist()).shape)
        self.assertEqual(answers(self.robot, q), answers(self.robot, grid))
        # Steps of edges as a planner has them, which numpy does not see as one dimension.
        turned = numpy.moveaxis(grid, 0, 2)
        self.assertEqual(answers(self.robot, turned.copy()), answers(self.robot, turned))
        place = numpy.unravel_index(self.robot.pairs_below(grid, 9.0)["state"], grid.shape[:-1])
        self.assertEqual(q[self.robot.pairs_below(q, 9.0)["state"]].tolist(), grid[place].tolist())

    def test_no_state_has_no_row(self):
        q = numpy.empty((0, 3))
        self.assertEqual([(0,), (0, 2), (0,), (0,)], [answer.shape for answer in (
            self.robot.minimum(q), self.robot.closest(q, 2), self.robot.below(q, 1.0), self.robot.pairs_below(q, 9.0))])
        self.assertEqual([(0,), (0, 3)], [answer.shape for answer in self.robot.gradient(q)])
        self.assertEqual([(0, 2), (0, 2, 3)], [answer.shape for answer in self.robot.gradient(q, 2)])

    def test_rows_behind_the_last_pair_are_unknown(self):
        rows = self.robot.closest([0.0, 0.0, 0.0], 5)
        self.assertEqual([Status.CONVERGED] * 3 + [Status.UNKNOWN] * 2, rows["status"].tolist())
        self.assertEqual([-1, -1], rows["pair"][3:].tolist())
        self.assertTrue(numpy.isnan(rows["distance"][3:]).all())

    def test_a_robot_without_pairs_has_no_minimum_and_nothing_below(self):
        robot = balls(only_pairs=[], exclude_pairs=[("base", "lamp"), ("arm", "lamp")])
        self.assertIn("No pair of links is checked.", robot.warnings)
        self.assertEqual(Status.UNKNOWN, robot.minimum([0.0, 0.0, 0.0])["status"])
        self.assertEqual(Verdict.ABOVE, robot.below([0.0, 0.0, 0.0], 1.0)["verdict"])
        self.assertEqual(0, len(robot.pairs_below([0.0, 0.0, 0.0], 1.0)))

    def test_files_of_rows_have_the_same_bytes_each_time(self):
        q = random_states(self.robot, 100, 2)
        files = [io.BytesIO(), io.BytesIO()]
        for file in files:
            numpy.save(file, self.robot.closest(q, 5))
        self.assertEqual(files[0].getvalue(), files[1].getvalue())
        files[0].seek(0)
        self.assertEqual(proximity.PAIR, numpy.load(files[0]).dtype)


class Positions(unittest.TestCase):
    """What q may be."""

    @classmethod
    def setUpClass(cls):
        cls.robot = demo()
        cls.q = random_states(cls.robot, repeats(300), 3)

    def test_the_layout_of_the_array_does_not_matter(self):
        wide = numpy.zeros((2 * len(self.q), 64))
        wide[::2, 1:33:2] = self.q
        bytes_before = numpy.zeros(self.q.nbytes + 1, numpy.uint8)
        unaligned = bytes_before[1:].view(numpy.float64).reshape(self.q.shape)
        unaligned[:] = self.q
        self.assertFalse(unaligned.flags.aligned)
        expected = answers(self.robot, self.q)
        for name, q in {
                "Fortran": numpy.asfortranarray(self.q),
                "spread": wide[::2, 1:33:2],
                "backwards": self.q[::-1, ::-1].copy()[::-1, ::-1],
                "big-endian": self.q.astype(">f8"),
                "unaligned": unaligned,
                "read-only": numpy.frombuffer(self.q.tobytes()).reshape(self.q.shape),
                "lists": self.q.tolist(),
        }.items():
            with self.subTest(name):
                self.assertEqual(expected, answers(self.robot, q))

    def test_a_state_that_is_repeated_without_memory_is_repeated(self):
        q = numpy.broadcast_to(self.q[0], (4, self.q.shape[1]))
        self.assertEqual(0, q.strides[0])
        for row in self.robot.minimum(q):
            self.assertEqual(self.robot.minimum(self.q[0])["distance"], row["distance"])

    def test_float32_is_converted_exactly(self):
        q = self.q.astype(numpy.float32)
        self.assertEqual(answers(self.robot, q.astype(numpy.float64)), answers(self.robot, q))

    def test_whole_numbers_are_converted(self):
        q = numpy.zeros((2, len(self.robot.joints)), int)
        self.assertEqual(answers(self.robot, q.astype(float)), answers(self.robot, q))

    def test_the_array_is_not_written_to(self):
        q = self.q.copy()
        answers(self.robot, q)
        self.assertEqual(self.q.tobytes(), q.tobytes())

    def test_a_ragged_list_is_refused(self):
        makes_objects = numpy.lib.NumpyVersion(numpy.__version__) < "1.24.0"  # later ones refuse what is ragged
        with self.assertRaises(TypeError if makes_objects else ValueError):
            self.robot.minimum([[0.0], [0.0, 1.0]])

    def test_a_position_that_is_not_finite_has_no_answer_and_spoils_no_other(self):
        q = self.q[:5].copy()
        q[1, 0], q[3, 2] = math.nan, -math.inf
        sound = [0, 2, 4]
        minimum, below, pairs_below = self.robot.minimum(q), self.robot.below(q, 0.1), self.robot.pairs_below(q, 0.1)
        rows, gradients = self.robot.gradient(q)
        for i in (1, 3):
            with self.subTest(state=i):
                self.assertEqual((Status.UNKNOWN, -1), (minimum["status"][i], minimum["pair"][i]))
                self.assertTrue(numpy.isnan(minimum["distance"][i]))
                self.assertEqual((-math.inf, math.inf), (minimum["lower"][i], minimum["upper"][i]))
                self.assertEqual((Verdict.UNKNOWN, -1), tuple(below[i]))
                self.assertEqual([Status.UNKNOWN], pairs_below["status"][pairs_below["state"] == i].tolist())
                self.assertTrue(numpy.isnan(gradients[i]).all())
        self.assertEqual(self.robot.minimum(self.q[:5])[sound].tobytes(), minimum[sound].tobytes())
        self.assertTrue(numpy.isfinite(gradients[sound]).all())

    def test_an_answer_that_does_not_fit_is_a_memory_error(self):
        with self.assertRaises(MemoryError):
            self.robot.closest(self.q, 2**31 - 1)


class SameAsCpp(unittest.TestCase):
    """The module and a program of C++ say the same of the same states, to the last bit."""

    DISTANCE, K = 0.1, 4

    def assert_same(self, robot, urdf, srdf):
        count = max(20, repeats(400))
        q = random_states(robot, count, 4)
        q[17, 3] = math.nan
        states = "\n".join(" ".join(position.hex() for position in state) for state in q.tolist())
        packages = ":".join(map(str, package_roots()))
        printed = subprocess.run([ANSWERS, urdf, srdf, packages, str(self.DISTANCE), str(self.K)], input=states, text=True,
                                 check=True, capture_output=True).stdout
        expected = [self.parsed(line) for line in printed.splitlines()]
        closest = robot.closest(q, self.K)
        known = closest[(closest["status"] != Status.UNKNOWN) | ((closest["state"] == 17) & (numpy.arange(self.K) == 0))]
        found = [*self.rows("minimum", robot, robot.minimum(q)), *self.rows("closest", robot, known),
                 *self.rows("pairs_below", robot, robot.pairs_below(q, self.DISTANCE)),
                 *(["below", i, *row] for i, row in enumerate(robot.below(q, self.DISTANCE).tolist()))]
        self.assertEqual(expected, found)
        self.assertGreater(len(found), count * (2 + self.K))

    @staticmethod
    def parsed(line):
        question, *words = line.split()
        if question == "below" or len(words) == 2:
            return [question, *map(int, words)]
        return [question, *map(int, words[:2]), *words[2:4], *map(int, words[4:7]),
                *(float.fromhex(word).hex() for word in words[7:])]

    @staticmethod
    def rows(question, robot, rows):
        for row in rows:
            if row["status"] == Status.UNKNOWN:
                yield [question, int(row["state"]), 0]
                continue
            vectors = numpy.concatenate([row["point_a"], row["point_b"], row["normal"]]).tolist()
            numbers = [float(row[field]) for field in ("distance", "lower", "upper")] + vectors
            yield [question, int(row["state"]), int(row["status"]), *robot.pairs[row["pair"]],
                   *(int(row[field]) for field in ("unique", "depth_is_lower_bound", "representation")),
                   *(number.hex() for number in numbers)]

    def test_of_the_robot_of_the_demo(self):
        self.assert_same(demo(), DEMO / "robot.urdf", DEMO / "robot.srdf")

    def test_of_the_panda(self):
        self.assert_same(panda(), PANDA / "urdf/panda.urdf", PANDA / "srdf/panda.srdf")


class Threads(unittest.TestCase):
    @staticmethod
    def make():
        return demo(threads=1)

    @classmethod
    def setUpClass(cls):
        cls.robot = cls.make()
        # More than one block of a thread: kBlock in src/python/questions.cpp.
        cls.q = random_states(cls.robot, 600 if IS_SANITIZED else 2000, 5)
        cls.q[543, 0] = math.nan
        cls.expected = answers(cls.robot, cls.q)

    def tearDown(self):
        self.robot.threads = 1

    def test_the_answers_do_not_depend_on_the_number_of_threads(self):
        for threads in (2, 3, 64):
            self.robot.threads = threads
            with self.subTest(threads=threads):
                self.assertEqual(self.expected, answers(self.robot, self.q))

    def test_the_answers_do_not_depend_on_the_states_beside_them(self):
        one_by_one = [self.robot.minimum(state) for state in self.q]
        together = self.robot.minimum(self.q)
        for field in proximity.PAIR.names[1:]:
            with self.subTest(field):
                self.assertEqual(together[field].tobytes(), numpy.stack([row[field] for row in one_by_one]).tobytes())
        self.assertEqual(self.expected, answers(self.robot, self.q.reshape(4, -1, self.q.shape[-1])))
        for ask in (lambda q: self.robot.guaranteed(q, 0.002)[1], self.robot.free_motion):
            self.assertEqual(ask(self.q).tobytes(), ask(self.q[::-1])[::-1].tobytes())

    def test_many_threads_of_python_may_ask_one_robot(self):
        found = {}

        def ask(number):
            found[number] = answers(self.robot, self.q)
        self.robot.threads = 2
        threads = [threading.Thread(target=ask, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual([self.expected] * 4, [found.get(number) for number in range(4)])

    def test_other_threads_of_python_run_during_a_question(self):
        # Nobody is made to give the GIL away: this thread sees what the other one counts only if the question does it.
        interval = sys.getswitchinterval()
        self.addCleanup(sys.setswitchinterval, interval)
        counted, is_over = [0], threading.Event()

        def count():
            while not is_over.is_set():
                counted[0] += 1
                time.sleep(0)  # gives the GIL away, and waits for it

        other = threading.Thread(target=count)
        other.start()
        sys.setswitchinterval(1000.0)
        grew = False
        for _ in range(100):
            before = counted[0]
            self.robot.minimum(self.q)
            grew = grew or counted[0] > before
            if grew:
                break
        is_over.set()
        other.join()
        self.assertTrue(grew)

    def test_a_signal_ends_a_long_question(self):
        class Interrupted(Exception):
            pass

        def interrupt(number, frame):
            raise Interrupted

        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, interrupt))
        joints = len(self.robot.joints)
        # Each state begins one number after the one before it. To answer all of them takes seconds at least.
        numbers = numpy.random.default_rng(6).uniform(-1, 1, 3_000_000)
        q = numpy.lib.stride_tricks.as_strided(numbers, (numbers.size - joints + 1, joints), 2 * numbers.strides, writeable=False)
        for threads in (1, 2):
            self.robot.threads = threads
            with self.subTest(threads=threads), self.assertRaises(Interrupted):
                signal.setitimer(signal.ITIMER_REAL, 0.05)
                self.robot.gradient(q)
        self.assertEqual(self.expected, answers(self.robot, self.q))


class ThreadsAmongObjects(Threads):
    test_other_threads_of_python_run_during_a_question = test_a_signal_ends_a_long_question = None  # the same with any robot

    @staticmethod
    def make():
        return Threads.make().with_object("table", proximity.Box((0.6, 1.2, 0.05)), (0.8, 0.0, 0.6)).with_object(
            "cup", proximity.Cylinder(0.03, 0.1), (0.1, 0.0, 0.0), link="left_hand", touch_links=["left_wrist"])


if __name__ == "__main__":
    cases.main()
