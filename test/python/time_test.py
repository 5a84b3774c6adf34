#!/usr/bin/env python3
"""The end of long questions: time budgets, and Ctrl-C in the middle of one."""

import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy

import cases
from cases import DEMO, SOURCE, demo, random_states
from proximity import Outcome, Status, Verdict

FOREVER = 1e9  # [s]
PATIENCE = 120.0  # [s] within which whatever ends has ended; an edge of ENDLESS takes longer

# The joints make 30,000 turns within one edge.
ENDLESS = """
import sys, signal
sys.path.insert(0, sys.argv[1])
import numpy, proximity
signal.signal(signal.SIGINT, signal.default_int_handler)
robot = proximity.Robot(sys.argv[2] + "/robot.urdf", sys.argv[2] + "/robot.srdf", packages=[sys.argv[3]], threads=int(sys.argv[4]))
q = numpy.random.default_rng(1).uniform(*robot.ranges.T, (4, len(robot.joints)))
fast = 1e5 * q[:1], -1e5 * q[:1]
print("begins", flush=True)
"""


def everything(robot, q, **time_budget):
    """The answers of all questions that take a budget, as arrays: about the states q, and the edges between them."""
    pair, guaranteed = robot.guaranteed(q, 0.01, **time_budget)
    rows, gradients = robot.gradient(q, **time_budget)
    motion = numpy.full_like(q, 1e-3)
    edges = dict(velocities=(numpy.ones_like(q[1:]), -numpy.ones_like(q[1:])), **time_budget)
    return [robot.minimum(q, **time_budget), robot.minimum(q, accuracy=1e-4, **time_budget), robot.closest(q, 3, **time_budget),
            robot.below(q, 0.05, **time_budget), robot.pairs_below(q, 0.05, **time_budget), rows, gradients, pair, guaranteed,
            robot.free_motion(q, 0.0, **time_budget), robot.free_scale(q, motion, **time_budget),
            robot.first_contact(q[1:], q[:-1], **time_budget), robot.minimum_between(q[1:], q[:-1], tolerance=1e-3, **time_budget),
            robot.minimum_between(q[1:], q[:-1], tolerance=1e-2, **edges)]


class TimeBudget(unittest.TestCase):
    def setUp(self):
        self.robot = demo()

    def test_what_it_does_not_end_is_answered_as_without_it(self):
        q = random_states(self.robot, 6, 3)
        expected = everything(self.robot, q)
        for seconds in (FOREVER, math.inf):
            for answer, known in zip(everything(self.robot, q, time_budget=seconds), expected):
                self.assertEqual(known.tobytes(), answer.tobytes())

    def test_without_time_nothing_is_known(self):
        for q in (random_states(self.robot, 300, 4), random_states(self.robot, 1, 4)):
            for answer in everything(self.robot, q, time_budget=0.0):
                if answer.dtype.names is None:
                    self.assertTrue(numpy.isnan(answer).all())
                elif "verdict" in answer.dtype.names:
                    self.assertTrue((answer["verdict"] == Verdict.UNKNOWN).all())
                else:
                    self.assertTrue((answer["status"] == Status.UNKNOWN).all())
            self.assertEqual(list(range(len(q))), self.robot.pairs_below(q, 0.05, time_budget=0.0)["state"].tolist())
            self.assertTrue((self.robot.first_contact(q, q, time_budget=0.0)["t_free"] == 0.0).all())
            self.assertTrue((self.robot.minimum_between(q, q, time_budget=0.0)["lower"] == -math.inf).all())
        for name in ("time_budget", "seconds"):
            rows, closest = self.robot.prove(**{name: 0.0})
            self.assertTrue((rows["outcome"] == Outcome.UNDECIDED).all())
            self.assertTrue(numpy.isnan(closest).all())

    def test_states_are_answered_or_unknown(self):
        q = random_states(self.robot, 20000, 5)
        expected = self.robot.minimum(q)
        for seconds in (0.0, 0.01, 0.05, 0.1, FOREVER):
            answer = self.robot.minimum(q, time_budget=seconds)
            known = answer["status"] != Status.UNKNOWN
            self.assertEqual(expected[known].tobytes(), answer[known].tobytes())
        self.assertTrue(known.all())

    def test_bounds_of_an_edge_that_it_ends_hold(self):
        q = random_states(self.robot, 3, 6)
        row = self.robot.minimum_between(q[0], q[1], velocities=(1e5 * q[0], -1e5 * q[0]), time_budget=1.0)
        self.assertEqual(Status.ITERATION_LIMIT, row["status"])
        self.assertLessEqual(row["lower"], row["upper"])
        self.assertLessEqual(row["lower"], self.robot.minimum(q[:2])["upper"].min())


# Begins to load a mesh of seconds. Afterwards it loads the same one with a tolerance of metres, which is one hull at once.
LOADING = """
import logging, os, signal, sys
sys.path.insert(0, sys.argv[1])
import proximity
signal.signal(signal.SIGINT, signal.default_int_handler)
logging.basicConfig(stream=sys.stdout, format="%(message)s", level=logging.INFO)
robot = "<robot name='r'><link name='a'>{}</link></robot>"
ball = "<collision><geometry><mesh filename='" + sys.argv[2] + "'/></geometry></collision>"
try:
    LOAD
    print("loaded")
except KeyboardInterrupt:
    print("interrupted", os.path.exists(os.environ["XDG_CACHE_HOME"] + "/proximity_server"))
print(len(proximity.Robot.from_text(robot.format(ball), mesh_tolerance=1.0).links))
"""


def bumpy_ball(rows, columns):
    """The text of an .obj file: a closed ball with bumps, of about 2 * rows * columns triangles."""
    lines = ["v 0 0 0.3", "v 0 0 -0.3"]
    for i in range(1, rows):
        for j in range(columns):
            t, p = math.pi * i / rows, 2 * math.pi * j / columns
            r = 0.3 * (1 + 0.08 * math.sin(t) * math.sin(13 * t) * math.cos(11 * p))
            lines.append(f"v {r * math.sin(t) * math.cos(p)} {r * math.sin(t) * math.sin(p)} {r * math.cos(t)}")

    def at(i, j):
        return 3 + (i - 1) * columns + j % columns

    for j in range(columns):
        lines += [f"f 1 {at(1, j)} {at(1, j + 1)}", f"f 2 {at(rows - 1, j + 1)} {at(rows - 1, j)}"]
        lines += [f"f {at(i, j)} {at(i + 1, j)} {at(i + 1, j + 1)} {at(i, j + 1)}" for i in range(1, rows - 1)]
    return "\n".join(lines)


class CtrlC(unittest.TestCase):
    """Sends SIGINT in the middle of questions that take minutes. Before, none but the last ended."""

    def expect_end(self, question, threads):
        script = ENDLESS + question
        with subprocess.Popen([sys.executable, "-W", "ignore", "-c", script, cases.MODULE, DEMO, SOURCE, str(threads)],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            try:
                self.assertEqual("begins\n", process.stdout.readline())
                time.sleep(0.5)  # so that it is in the middle of the question
                self.assertIsNone(process.poll())
                process.send_signal(signal.SIGINT)
                _, errors = process.communicate(timeout=PATIENCE)
            except Exception:
                process.kill()
                raise
        self.assertEqual(-signal.SIGINT, process.returncode, errors)
        self.assertIn("KeyboardInterrupt", errors)

    def test_ends_an_edge(self):
        self.expect_end("robot.minimum_between(q[:1], q[2:3], velocities=fast)", 1)

    def test_ends_edges_of_several_threads(self):
        self.expect_end("robot.minimum_between(numpy.repeat(q[:1], 40, 0), q[2:3], velocities=fast)", 2)

    def test_ends_an_edge_with_a_tracking_error(self):
        self.expect_end("robot.minimum_between(q[:1], q[2:3], velocities=fast, tracking_error=0.01)", 1)

    def test_ends_a_proof(self):
        self.expect_end("robot.prove(boxes=10**9)", 2)

    def test_ends_guaranteed_distances(self):
        self.expect_end("robot.guaranteed(numpy.repeat(q, 10**6, 0), 0.01)", 2)

    def expect_stopped(self, load):
        """Sends SIGINT while the mesh is decomposed. Before, the load ended when it was done, and its pieces were kept."""
        with tempfile.TemporaryDirectory() as folder:
            mesh = pathlib.Path(folder, "ball.obj")
            mesh.write_text(bumpy_ball(64, 128))
            with subprocess.Popen([sys.executable, "-W", "ignore", "-u", "-c", LOADING.replace("LOAD\n", load + "\n"), cases.MODULE, mesh],
                                  env={**os.environ, "XDG_CACHE_HOME": folder}, stdout=subprocess.PIPE, text=True) as process:
                try:
                    self.assertIn("decomposing", process.stdout.readline())
                    time.sleep(0.5)  # so that it is in the middle of that
                    process.send_signal(signal.SIGINT)
                    output, _ = process.communicate(timeout=PATIENCE)
                except Exception:
                    process.kill()
                    raise
        self.assertEqual("interrupted False\n1\n", output)
        self.assertEqual(0, process.returncode)

    def test_ends_the_loading_of_a_robot(self):
        self.expect_stopped("proximity.Robot.from_text(robot.format(ball))")

    def test_ends_the_loading_of_an_object(self):
        self.expect_stopped("proximity.Robot.from_text(robot.format('')).with_object('ball', proximity.MeshFile(sys.argv[2]))")


if __name__ == "__main__":
    cases.main()
