#!/usr/bin/env python3
"""Holds clearancetest to passing and to each way of failing, in its own words."""

import math
import pathlib
import subprocess
import threading
import unittest

import roslib.packages
import rosgraph_msgs.msg
import rospy
import rostest
import sensor_msgs.msg
import tf2_msgs.msg
from clearancetest_child import Child, gantry_at
from proximity_server.msg import Clearance, LinkInfo, ModelInfo, PairInfo, Proximity, QueryStatus, ShapeInfo
from proximity_server.srv import QueryPairs, QueryPairsResponse

PERIOD = 0.02  # [s] of the fake
TOPIC = "/fake/clearance"

# The robot of the fake. The elbow turns in every message.
ARM = (pathlib.Path(__file__).resolve().parents[2] / "robots/two_joints.urdf").read_text()


def arm(n):
    """{joint: position} of the n-th message."""
    return {"elbow": 0.25 * n, "wrist": -1.0}


def proximity(lower, a="hand", b="head"):
    """A pair whose bounds are 1 mm apart."""
    result = Proximity(state=Proximity.SEPARATED, distance=lower + 0.0005, lower_bound=lower, upper_bound=lower + 0.001)
    result.a.link, result.b.link = a, b
    return result


THRESHOLDS = {Clearance.CLEAR: 0.05, Clearance.WARN: 0.05, Clearance.STOP: 0.02, Clearance.COLLISION: 0.0}


def clearance(lower, level=Clearance.CLEAR, deciding=None, threshold=None):
    """The closest pair decides, unless another one is given with its threshold."""
    closest = proximity(lower)
    return Clearance(level=level, minimum=closest, deciding=deciding or closest,
                     deciding_threshold=THRESHOLDS[level] if threshold is None else threshold)


def invalid():
    unknown = Proximity(distance=math.nan, lower_bound=math.nan, upper_bound=math.nan)
    return Clearance(level=Clearance.INVALID, minimum=unknown,
                     status=QueryStatus(QueryStatus.TF_STALE, "joint elbow is 3 s old"))


class Fake:
    """Publishes what `messages` says of the n-th message (None: nothing), from the moment on when somebody listens."""

    def __init__(self, messages, answer=None, positions=arm):
        self.messages, self.positions, self.count = messages, positions, 0
        rospy.set_param("/arm_description", ARM)
        rospy.set_param("/fake/robot_description", "arm_description")
        self.publisher = rospy.Publisher(TOPIC, Clearance, queue_size=100)
        self.joints = rospy.Publisher("/joint_states", sensor_msgs.msg.JointState, queue_size=100)
        self.service = rospy.Service("/fake/query_pairs", QueryPairs, answer) if answer else None
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()
        self.publisher.unregister()
        self.joints.unregister()
        if self.service:
            self.service.shutdown()

    def run(self):
        while not self.over.wait(PERIOD):
            if not self.publisher.get_num_connections() or not self.joints.get_num_connections():
                continue
            message = self.messages(self.count)
            self.count += 1
            if message is None:
                continue
            # Stamps that are easily recognised: the n-th message is of the n-th second.
            message.header.stamp = rospy.Time(self.count)
            positions = self.positions(self.count)
            state = sensor_msgs.msg.JointState(name=list(positions), position=list(positions.values()))
            state.header.stamp = message.header.stamp
            self.joints.publish(state)
            self.publisher.publish(message)


def run_beside(messages, answer=None, positions=arm, **parameters):
    """{case: failure} of clearancetest beside a fake."""
    with Fake(messages, answer, positions):
        return Child(**{"topic": TOPIC, "duration": 0.4, "max_silence": 5.0, **parameters}).cases()


class BesideAFake(unittest.TestCase):
    def test_passes_where_all_is_clear(self):
        cases = run_beside(lambda _: clearance(0.05), minimum=0.049, worst_level="CLEAR", min_rate=1.0)
        self.assertEqual(cases, dict.fromkeys(
            ["test_minimum", "test_worst_level", "test_invalid", "test_silence", "test_rate", "test_joints", "test_limits",
             "test_motion"], ""))

    def test_cases_that_are_not_asked_are_not_reported(self):
        self.assertEqual(sorted(run_beside(lambda _: clearance(0.05), worst_level="STOP", moving_joints=[])),
                         ["test_invalid", "test_joints", "test_limits", "test_silence", "test_worst_level"])

    def test_names_the_worst_moment_with_its_joints(self):
        distances = {3: 0.03, 5: 0.01, 7: 0.02}
        cases = run_beside(lambda n: clearance(distances.get(n, 0.5), Clearance.WARN), minimum=0.04)
        for words in ("not proven to stay above the minimum of 0.04 m", "at 6.000000 s hand - head",
                      "distance 0.0105 m", "bounds [0.01, 0.011]", "level WARN (threshold 0.05 m); joints: elbow=1.5, wrist=-1",
                      "3 of", "the first of 4.000000 s"):
            self.assertIn(words, cases["test_minimum"])

    def test_names_every_pair_below_with_its_worst_moment(self):
        def message(n):
            result = clearance(0.01)
            result.below_threshold = [result.minimum, proximity(0.03 if n == 4 else 0.035, "wrist", "chest"),
                                      proximity(0.05, "knee", "floor")]
            return result

        words = run_beside(message, minimum=0.04)["test_minimum"]
        self.assertRegex(words, r"These 2 pairs, each at its worst:\n"
                         r"  hand - head: distance 0\.0105 m, bounds \[0\.01, 0\.011\], at 1\.0+ s, in \d+ messages\n"
                         r"  chest - wrist: distance 0\.0305 m, bounds \[0\.03, 0\.031\], at 5\.0+ s, in \d+ messages$")

    def test_names_every_pair_at_a_level_that_is_worse(self):
        def message(n):
            result = clearance(0.01, Clearance.STOP)
            result.below_threshold = [result.minimum, proximity(0.03, "wrist", "chest"), proximity(0.04, "knee", "floor")]
            result.levels = [Clearance.STOP, Clearance.STOP, Clearance.WARN]
            return result

        words = run_beside(message, worst_level="WARN")["test_worst_level"]
        self.assertRegex(words, r"(?s)These 2 pairs, each at its worst:\n  hand - head: STOP, distance 0\.0105 m, .*\n"
                         r"  chest - wrist: STOP, distance 0\.0305 m, [^\n]* messages$")

    def test_the_lower_bound_decides(self):
        # The distance is 0.0405, proven is 0.04: not above it.
        self.assertIn("not proven", run_beside(lambda _: clearance(0.04), minimum=0.04)["test_minimum"])

    def test_a_bound_that_is_no_number_is_too_close(self):
        self.assertIn("not proven", run_beside(lambda _: clearance(math.nan), minimum=-1.0)["test_minimum"])

    def test_a_depth_that_may_be_deeper_proves_nothing(self):
        def deep(_):
            message = clearance(-0.01, Clearance.COLLISION)
            message.minimum.depth_is_lower_bound = True
            return message

        self.assertIn("not proven", run_beside(deep, minimum=-0.5)["test_minimum"])

    def test_the_guaranteed_distances_of_a_message(self):
        def message(n, least=0.03):
            result = clearance(0.1)
            result.minimum.guaranteed = 0.05
            result.below_threshold = [result.minimum, proximity(0.2, "wrist", "chest")]
            result.below_threshold[1].guaranteed = least if n == 4 else 0.15
            return result

        self.assertEqual(run_beside(message, min_guaranteed=0.02)["test_min_guaranteed"], "")
        words = run_beside(message, min_guaranteed=0.04)["test_min_guaranteed"]
        for part in ("not guaranteed to stay above 0.04 m. Worst: 0.03 m, at 5.000000 s wrist - chest", "1 of", "elbow=1.25"):
            self.assertIn(part, words)
        words = run_beside(lambda n: message(n, math.nan), min_guaranteed=0.04)["test_min_guaranteed"]
        self.assertIn("Worst: -inf m, at 5.000000 s wrist - chest", words)

    def test_a_level_that_is_worse(self):
        levels = {4: Clearance.STOP, 6: Clearance.COLLISION}
        cases = run_beside(lambda n: clearance(0.5 - 0.05 * (n == 6), levels.get(n, Clearance.WARN)), worst_level="WARN")
        for words in ("level COLLISION is worse than WARN", "at 7.000000 s hand - head", "2 of", "the first of 5.000000 s",
                      "elbow=1.75"):
            self.assertIn(words, cases["test_worst_level"])

    def test_the_pair_that_sets_the_level_is_named_with_its_threshold(self):
        # The closest pair keeps 0.012 m, and may be as near. The worst moment is the one in which the other pair is farthest below
        # its threshold: 0.3 below 0.31, and not 0.2 below 0.205.
        def message(n):
            lower, threshold = {4: (0.2, 0.205), 6: (0.3, 0.31)}.get(n, (0.5, 0.2))
            return clearance(0.012, Clearance.STOP if n in (4, 6) else Clearance.WARN, proximity(lower, "wrist", "shoulder"),
                             threshold)

        words = run_beside(message, worst_level="WARN")["test_worst_level"]
        self.assertIn("level STOP is worse than WARN. Worst: at 7.000000 s wrist - shoulder: distance 0.3005 m, bounds [0.3, "
                      "0.301], level STOP (threshold 0.31 m); joints", words)
        # The requirement of a distance is one of the closest pair.
        words = run_beside(lambda _: message(4), minimum=0.02)["test_minimum"]
        self.assertIn("hand - head: distance 0.0125 m, bounds [0.012, 0.013], level STOP (threshold 0.205 m) of wrist - "
                      "shoulder: distance 0.2005 m, bounds [0.2, 0.201]; joints", words)

    def test_silence_from_the_start(self):
        cases = run_beside(lambda _: None, minimum=0.0, wait_time=1.0)
        self.assertEqual(list(cases), ["test_first_message"])
        self.assertIn("no message on /fake/clearance within the wait_time of 1 s", cases["test_first_message"])

    def test_silence_later(self):
        cases = run_beside(lambda n: clearance(0.5) if n < 5 else None, minimum=0.0, duration=1.0, max_silence=0.5)
        self.assertRegex(cases["test_silence"], r"silence on /fake/clearance for 0\.\d+ s, allowed are 0\.5 s: until the "
                         r"end, after the message of 5\.000000 s")
        self.assertEqual(cases["test_minimum"], "")

    def test_invalid_all_the_time(self):
        cases = run_beside(lambda _: invalid(), minimum=0.0, wait_time=1.0)
        self.assertEqual(list(cases), ["test_first_message"])
        self.assertIn("was INVALID within the wait_time of 1 s: TF_STALE: joint elbow is 3 s old", cases["test_first_message"])

    def test_invalid_at_the_start_is_waited_for(self):
        self.assertEqual(set(run_beside(lambda n: invalid() if n < 5 else clearance(0.5), minimum=0.0).values()), {""})

    def test_one_invalid_message_is_too_many_by_default(self):
        cases = run_beside(lambda n: invalid() if n == 5 else clearance(0.5), minimum=0.0)
        for words in ("nothing was known for", "allowed are 0 s", "INVALID since 6.000000 s: TF_STALE: joint elbow is 3 s old"):
            self.assertIn(words, cases["test_invalid"])

    def test_invalid_for_no_longer_than_allowed(self):
        cases = run_beside(lambda n: invalid() if n % 10 == 9 else clearance(0.5), minimum=0.0, max_invalid=2.0)
        self.assertEqual(set(cases.values()), {""})

    def test_invalid_for_longer_than_allowed(self):
        cases = run_beside(lambda n: invalid() if n > 4 else clearance(0.5), minimum=0.0, duration=1.0, max_invalid=0.3)
        self.assertRegex(cases["test_invalid"], r"nothing was known for 0\.\d+ s, allowed are 0\.3 s: INVALID since 6\.0")

    def test_a_rate_that_is_too_low(self):
        cases = run_beside(lambda n: clearance(0.5) if n % 10 == 0 else None, minimum=0.0, duration=1.0, min_rate=20.0)
        self.assertRegex(cases["test_rate"], r"the rate is too low: \d+ messages in 1 s: \d+ Hz, at least 20 Hz are wanted")

    def test_a_joint_that_the_robot_does_not_have(self):
        misspelt = lambda n: {"elbow": 0.25 * n, "wirst": -1.0, "gripper": 1.0}
        words = run_beside(lambda _: clearance(0.5), positions=misspelt, minimum=0.0)["test_joints"]
        self.assertIn("/joint_states has joints that the URDF does not have: 'gripper', 'wirst' (did you mean 'wrist'?)", words)
        words = run_beside(lambda _: clearance(0.5), positions=misspelt, minimum=0.0, other_joints=["gripper", "wirst"])
        self.assertEqual(set(words.values()), {""})

    def test_unknown_joints_are_told_where_nothing_becomes_valid(self):
        words = run_beside(lambda _: invalid(), positions=lambda _: {"elbw": 0.0}, minimum=0.0, wait_time=1.0)["test_first_message"]
        self.assertIn("TF_STALE: joint elbow is 3 s old. /joint_states has joints that the URDF does not have: 'elbw' (did you mean "
                      "'elbow'?)", words)

    def test_positions_beyond_limits(self):
        beyond = lambda n: {"elbow": 100.0 + n, "wrist": {4: 0.6, 6: -9.9}.get(n, 0.5005)}
        cases = run_beside(lambda _: clearance(0.5), positions=beyond, minimum=0.0)
        self.assertEqual(cases["test_limits"], "positions beyond the limits of the URDF by more than 0.001, the worst of each joint: "
                         "wrist=-9.9 at 6.000000 s, limits [-1.5, 0.5] rad")
        cases = run_beside(lambda _: clearance(0.5), positions=beyond, minimum=0.0, limit_tolerance=9.0)
        self.assertEqual(cases["test_limits"], "")

    def test_a_robot_that_does_not_move(self):
        rest = lambda n: {"elbow": 2.0 + 0.0004 * (n % 2), "wrist": -1.0}
        cases = run_beside(lambda _: clearance(0.5), positions=rest, minimum=0.0)
        self.assertRegex(cases["test_motion"], r"the robot does not move: within 0\.4 s no more than 0\.001 rad or m: elbow=2(\.0004)?, "
                         r"wrist=-1\. If the robot may rest")
        cases = run_beside(lambda _: clearance(0.5), positions=rest, minimum=0.0, moving_joints=[])
        self.assertEqual(set(cases.values()), {""})

    # Regression: every joint was taken for one of the robot.
    def test_a_robot_whose_urdf_is_nowhere(self):
        with Fake(lambda _: clearance(0.5)):
            rospy.set_param("/fake/robot_description", "nowhere")
            words = Child(topic=TOPIC, duration=0.4, max_silence=5.0, minimum=0.0).cases()["test_joints"]
        self.assertIn("no URDF with joints was found in the parameter nowhere of /fake", words)

    def test_a_robot_whose_joints_nobody_tells(self):
        cases = run_beside(lambda _: clearance(0.5), positions=lambda _: {}, minimum=0.0)
        self.assertIn("nothing was heard on /joint_states", cases["test_motion"])

    def test_joints_that_have_to_move(self):
        cases = run_beside(lambda _: clearance(0.5), minimum=0.0, moving_joints=["elbow"])
        self.assertEqual(set(cases.values()), {""})
        only_elbow = lambda n: {"elbow": 0.25 * n}
        words = run_beside(lambda _: clearance(0.5), minimum=0.0, moving_joints=["elbow", "wrist"])["test_motion"]
        self.assertIn("these joints do not move: within 0.4 s no more than 0.001 rad or m: wrist=-1", words)
        words = run_beside(lambda _: clearance(0.5), positions=only_elbow, minimum=0.0, moving_joints=["wrist"])["test_motion"]
        self.assertIn("wrist (not on /joint_states)", words)
        words = run_beside(lambda _: clearance(0.5), minimum=0.0, moving_joints=["wirst"])["test_parameters"]
        self.assertEqual(words, "parameter moving_joints: there is no joint 'wirst' (did you mean 'wrist'?)")

    def test_why_the_node_has_ended(self):
        listens = threading.Event()
        listener = rospy.SubscribeListener()
        listener.peer_subscribe = lambda *_: listens.set()
        log = rospy.Publisher("/rosout", rosgraph_msgs.msg.Log, subscriber_listener=listener, queue_size=10)
        ended = rosgraph_msgs.msg.Log(level=rosgraph_msgs.msg.Log.FATAL, name="/fake", msg="there is no mesh\nof 'hand'")
        other = rosgraph_msgs.msg.Log(level=rosgraph_msgs.msg.Log.FATAL, name="/another", msg="no joint 'elbw'")
        harmless = rosgraph_msgs.msg.Log(level=rosgraph_msgs.msg.Log.ERROR, name="/fake", msg="all is well")
        child = Child(topic=TOPIC, minimum=0.0, duration=0.4, wait_time=5.0)
        self.assertTrue(listens.wait(30.0), "clearancetest does not listen to /rosout")
        for message in (other, harmless, ended):
            log.publish(message)
        words = child.cases()["test_first_message"]
        self.assertTrue(words.startswith("no message on /fake/clearance within the wait_time of 5 s; /fake ended with: there is no mesh\n"
                                         "of 'hand'; "), words)
        self.assertIn("; /another ended with: no joint 'elbw'", words)
        self.assertNotIn("all is well", words)

    def test_a_failure_is_the_words_alone(self):
        child = Child(topic=TOPIC, duration=0.4, minimum="far")
        self.assertEqual(child.cases(), {"test_parameters": "parameter minimum: 'far' is no number of at least -1e+06"})
        for part in ("Traceback", "line ", "clearancetest.py"):
            self.assertNotIn(part, child.output)

    def test_wrong_parameters(self):
        children = [(Child(**{"duration": 0.4, **parameters}), words) for parameters, words in (
                ({}, "parameter minimum, min_guaranteed or worst_level is missing, or one about stops"),
                ({"minimum": "far"}, "parameter minimum: 'far' is no number"),
                ({"minimum": 0.0, "duration": 0.0}, "parameter duration is missing, or 0"),
                ({"minimum": 0.0, "max_invalid": -1.0}, "parameter max_invalid: -1.0 is no number of at least 0"),
                ({"worst_level": "COLLISION"}, "parameter worst_level: 'COLLISION' is none of CLEAR, WARN, STOP"),
                ({"worst_level": "WARN", "pairs": [["a", "b"]]}, "parameter pairs wants minimum"),
                ({"minimum": 0.0, "pairs": ["a", "b"]}, "parameter pairs: ['a', 'b'] is no list of pairs"),
                ({"worst_level": "WARN", "except_pairs": [["a", "b"]]}, "parameter except_pairs wants minimum"),
                ({"minimum": 0.0, "pairs": [["a", "b"]], "except_pairs": [["a", "c"]]}, "parameter except_pairs leaves out of all pairs"),
                ({"minimum": 0.0, "moving_joints": "elbow"}, "parameter moving_joints: 'elbow' is no list of names"),
                ({"minimum": 0.0, "minumum": 0.1}, "parameter minumum is unknown; there are: "))]
        for child, words in children:
            cases = child.cases()
            self.assertEqual(list(cases), ["test_parameters"])
            self.assertIn(words, cases["test_parameters"])


class StopsBesideAFake(unittest.TestCase):
    """The fake's n-th message comes 0.02 s after the one before. It stops from the 20th to the 49th."""

    def setUp(self):
        self.model = rospy.Publisher("/fake/model_info", ModelInfo, queue_size=1, latch=True)

    def tearDown(self):
        self.model.unregister()

    def run_with(self, positions, lower=0.015, message=None, **parameters):
        """(failures by case, metrics)."""
        stop = message or clearance(lower, Clearance.STOP)
        with Fake(lambda n: stop if 20 <= n < 50 else clearance(0.5), None, positions):
            child = Child(**{"topic": TOPIC, "duration": 2.0, "max_silence": 5.0, **parameters})
            return child.cases(), child.metrics

    @staticmethod
    def moving(until, again=10**9):
        """Turns by 0.25 rad in each message, but rests from the message `until` to `again`."""
        return lambda n: {"elbow": 0.25 * (min(n, until) + max(0, n - again)), "wrist": -1.0}

    def test_times_of_a_stop(self):
        cases, metrics = self.run_with(self.moving(30, 80), min_stops=1, max_time_to_stop=5.0, max_time_to_resume=5.0, max_time_held=0.9)
        self.assertEqual(set(cases.values()), {""})
        self.assertEqual(metrics["stops"], 1)
        # Messages take longer on a busy machine, never less.
        self.assertGreater(metrics["time_to_stop"], 0.1)
        self.assertGreater(metrics["time_to_resume"], 0.4)
        self.assertGreater(metrics["time_held"], 0.2)
        self.assertLess(metrics["time_held"], 0.5)

    def test_times_that_are_too_long(self):
        cases, _ = self.run_with(self.moving(30, 80), max_time_to_stop=0.05, max_time_to_resume=0.2, max_time_held=0.1)
        self.assertRegex(cases["test_time_to_stop"], r"longest time to stop: 0\.\d+ s, of the stop at 21\.0+ s, of 1 stops, "
                         r"allowed are 0\.05 s")
        self.assertRegex(cases["test_time_to_resume"], r"longest time to resume: \d\.\d+ s, of the stop at 21\.0+ s.*, allowed are 0\.2 s")
        self.assertRegex(cases["test_time_held"], r"at STOP, COLLISION or INVALID for [\d.]+ % of the time, allowed are 10 %")

    def test_a_robot_that_does_not_obey(self):
        cases, metrics = self.run_with(self.moving(10**9), max_time_to_stop=1.0)
        self.assertIn("allowed are 1 s", cases["test_time_to_stop"])
        self.assertGreater(metrics["time_to_stop"], 1.0)

    def test_a_robot_that_stands_still_at_a_stop_has_no_time_to_stop(self):
        cases, metrics = self.run_with(self.moving(2, 80), max_time_to_stop=0.0, max_time_to_resume=0.2)
        self.assertEqual(cases["test_time_to_stop"], "")
        self.assertNotIn("time_to_stop", metrics)
        self.assertIn("allowed are 0.2 s", cases["test_time_to_resume"])

    def test_invalid_holds_a_robot_too(self):
        cases, metrics = self.run_with(self.moving(30), message=invalid(), max_invalid=5.0, max_time_to_stop=0.0, max_false_stops=0.0)
        self.assertIn("allowed are 0 s", cases["test_time_to_stop"])
        self.assertEqual(cases["test_false_stops"], "")
        self.assertNotIn("false_stops", metrics)

    def test_times_of_a_robot_that_nobody_tells(self):
        cases, _ = self.run_with(lambda _: {}, moving_joints=[], max_time_to_stop=1.0)
        self.assertIn("nothing was heard on joint_states", cases["test_time_to_stop"])

    def test_fewer_stops_than_wanted(self):
        cases, _ = self.run_with(self.moving(30), min_stops=2, moving_joints=[])
        self.assertEqual(cases["test_stops"], "1 stops, at least 2 are wanted")

    def publish_model(self, padding, deviation=0.0):
        shapes = [ShapeInfo(deviation=deviation)]
        self.model.publish(ModelInfo(links=[LinkInfo(name="hand", padding=padding, shapes=shapes), LinkInfo(name="head", shapes=shapes)],
                                     pairs=[PairInfo(link_a="hand", link_b="head", padding=0.001)]))

    def test_a_stop_by_padding_is_false(self):
        self.publish_model(0.01)  # 0.015 + 0.01 + 0.001 > 0.02
        cases, metrics = self.run_with(self.moving(30), max_false_stops=0.5)
        self.assertEqual(cases["test_false_stops"], "allowed is a share of 0.5: 1 of 1 stops were envelope, 0 real, 0 open\n"
                         "  21.000000 s: the surfaces of hand - head kept 0.026 m, stop below 0.02 m")
        self.assertEqual((metrics["false_stops"], metrics["open_stops"]), (1.0, 0.0))

    def test_a_stop_within_the_stop_distance_is_real(self):
        self.publish_model(0.001)  # at most 0.016 + 0.001 + 0.001 < 0.02
        cases, metrics = self.run_with(self.moving(30), max_false_stops=0.0)
        self.assertEqual(cases["test_false_stops"], "")
        self.assertEqual((metrics["false_stops"], metrics["open_stops"]), (0.0, 0.0))

    def test_a_stop_that_depends_on_pieces_is_open(self):
        self.publish_model(0.001, deviation=0.01)  # between 0.017 and 0.038
        cases, metrics = self.run_with(self.moving(30), max_false_stops=0.0)
        self.assertEqual(cases["test_false_stops"], "")
        self.assertEqual((metrics["false_stops"], metrics["open_stops"]), (0.0, 1.0))

    def test_a_stop_without_the_padding_is_open(self):
        _, metrics = self.run_with(self.moving(30), max_false_stops=0.0)
        self.assertEqual((metrics["false_stops"], metrics["open_stops"]), (0.0, 1.0))

    def test_a_stop_by_uncertainty_is_false(self):
        self.publish_model(0.0)
        _, metrics = self.run_with(self.moving(30), lower=0.03, max_false_stops=1.0)
        self.assertEqual(metrics["false_stops"], 1.0)

    def test_a_share_is_at_most_one(self):
        cases = Child(topic=TOPIC, duration=0.4, max_time_held=1.5).cases()
        self.assertEqual(cases, {"test_parameters": "parameter max_time_held: 1.5 is no share, which is at most 1"})


class NamedPairsBesideAFake(unittest.TestCase):
    PAIRS = [["left", "right"], ["left", "head"]]

    def answer_with(self, distances):
        """A service that knows these distances by second; all else is 0.5 m."""

        def answer(request):
            self.assertEqual([[a.link, b.link] for a, b in zip(request.a, request.b)], self.PAIRS)
            response = QueryPairsResponse(success=True)
            response.header.stamp = request.stamp
            lower = distances.get(request.stamp.secs, 0.5)
            response.pairs = [proximity(0.5, *self.PAIRS[0]), proximity(lower, *self.PAIRS[1])]
            return response

        return answer

    def test_only_the_named_pairs_count(self):
        # The closest pair of the messages is another one.
        cases = run_beside(lambda _: clearance(-0.1), self.answer_with({}), minimum=0.4, pairs=self.PAIRS)
        self.assertEqual(set(cases.values()), {""})

    def test_a_named_pair_that_no_message_lists(self):
        cases = run_beside(lambda _: clearance(0.6), self.answer_with({6: 0.1}), minimum=0.4, pairs=self.PAIRS)
        self.assertIn("at 6.000000 s left - head: distance 0.1005 m", cases["test_minimum"])
        self.assertIn("of the named pairs", cases["test_minimum"])

    def test_nobody_offers_the_service(self):
        cases = run_beside(lambda _: clearance(0.6), minimum=0.4, pairs=self.PAIRS, wait_time=1.0)
        self.assertEqual(list(cases), ["test_pairs"])
        self.assertIn("/fake/query_pairs, and nobody offers it", cases["test_pairs"])

    def test_a_moment_without_an_answer_is_not_clear(self):
        known = self.answer_with({})

        def answer(request):
            response = known(request)
            if request.stamp.secs == 6:
                response.status = QueryStatus(QueryStatus.TF_EXTRAPOLATION, "tf has forgotten")
                response.pairs[1].lower_bound = math.nan
            return response

        cases = run_beside(lambda _: clearance(0.6), answer, minimum=0.4, pairs=self.PAIRS)
        self.assertIn("INVALID since 6.000000 s: /fake/query_pairs: TF_EXTRAPOLATION: tf has forgotten", cases["test_invalid"])


class InSimulatedTime(unittest.TestCase):
    """Beside a fake whose messages come with the clock."""

    def run_with_clock(self, clock, message=lambda _: clearance(0.5), **parameters):
        """`clock`: [s] of the n-th message."""
        publisher = rospy.Publisher("/clock", rosgraph_msgs.msg.Clock, queue_size=100)
        rospy.set_param("/use_sim_time", True)

        def publish(n):
            publisher.publish(rospy.Time(clock(n)))
            return message(n)

        try:
            with Fake(publish):
                child = Child(**{"topic": TOPIC, "minimum": 0.0, **parameters})
                return child.cases()
        finally:
            rospy.delete_param("/use_sim_time")
            publisher.unregister()

    def test_the_duration_is_one_of_the_clock(self):
        # 2 s of the clock are 100 messages, whatever the wall says.
        cases = self.run_with_clock(lambda n: 0.02 * n, duration=2.0, min_rate=45.0)
        self.assertEqual(set(cases.values()), {""})

    def test_jumps_are_neither_time_nor_silence(self):
        # From 0 to the time of a bag, and back to its start.
        cases = self.run_with_clock(lambda n: 0.0 if n < 10 else 1.6e9 + 0.02 * (n % 40), duration=2.0, min_rate=40.0)
        self.assertEqual(set(cases.values()), {""})

    def test_a_clock_that_stands_still(self):
        cases = self.run_with_clock(lambda n: min(0.02 * n, 1.0), duration=3.0, wait_time=2.0)
        self.assertEqual(list(cases), ["test_clock"])
        self.assertIn("/clock stood still for 2 s of wall time", cases["test_clock"])

    def test_one_invalid_message_is_too_many_even_if_the_clock_does_not_move_meanwhile(self):
        cases = self.run_with_clock(lambda n: 0.02 * (n - n % 5), lambda n: invalid() if n == 52 else clearance(0.5),
                                    duration=2.0)
        self.assertIn("nothing was known for 0 s, allowed are 0 s: INVALID since 53.000000 s", cases["test_invalid"])

    def test_silence_counts_by_the_clock(self):
        cases = self.run_with_clock(lambda n: 0.02 * n, lambda n: clearance(0.5) if n < 60 or n > 160 else None,
                                    duration=4.0, max_silence=1.5)
        self.assertIn("silence on /fake/clearance for", cases["test_silence"])


class BesideTheNode(unittest.TestCase):
    """Base and ball of gantry.urdf are 0.2 m apart; ball and block sqrt(0.3^2 + 0.9^2) - 0.1 = 0.8487 m."""

    @classmethod
    def setUpClass(cls):
        tf = rospy.Publisher("/tf", tf2_msgs.msg.TFMessage, queue_size=10)

        def publish(_):
            tf.publish(gantry_at(0.4, rospy.Time.now()))

        cls.robot = rospy.Timer(rospy.Duration(0.02), publish)

    @classmethod
    def tearDownClass(cls):
        cls.robot.shutdown()
        cls.robot.join()

    def run_on(self, node, **parameters):
        # The limits are wide, as a busy machine delays tf. The robot rests.
        return Child(**{"topic": f"/{node}/clearance", "duration": 1.0, "max_invalid": 1.0, "max_silence": 5.0, "moving_joints": [],
                        **parameters}).cases()

    def test_the_default_topic_is_that_of_the_launch_file(self):
        cases = Child(duration=1.0, minimum=0.19, max_invalid=1.0, max_silence=5.0, moving_joints=[]).cases()
        self.assertEqual(set(cases.values()), {""})

    def test_a_robot_that_keeps_clear(self):
        cases = self.run_on("all_pairs", minimum=0.1999999, worst_level="CLEAR", min_rate=5.0)
        self.assertEqual(set(cases.values()), {""})

    def test_a_robot_that_is_too_close(self):
        words = self.run_on("all_pairs", minimum=0.21)["test_minimum"]
        self.assertRegex(words, r"base - ball: distance (0\.2|0\.1999999\d*|0\.2000000\d*) m")
        self.assertIn("level CLEAR", words)

    def test_a_pair_that_is_farther_than_the_list_reaches(self):
        cases = self.run_on("all_pairs", minimum=0.84, pairs=[["ball", "block"]])
        self.assertEqual(set(cases.values()), {""})
        self.assertIn("ball - block: distance 0.8486", self.run_on(
            "all_pairs", minimum=0.85, pairs=[["ball", "block"]])["test_minimum"])

    def test_a_pair_with_a_threshold_of_its_own(self):
        # The closest pair, base - ball at 0.2 m, is clear; block - ball at 0.8487 m is not, by its own thresholds.
        cases = self.run_on("own_thresholds", worst_level="WARN", minimum=0.21)
        self.assertRegex(cases["test_worst_level"], r"level STOP is worse than WARN. Worst: at [\d.]+ s block - ball: distance "
                         r"0\.8486\d* m, bounds \[0\.8486\d*, 0\.8486\d*\], level STOP \(threshold 0\.86 m\); joints")
        self.assertRegex(cases["test_minimum"], r"base - ball: .* level STOP \(threshold 0\.86 m\) of block - ball: distance 0\.8486")
        self.assertEqual(self.run_on("own_thresholds", worst_level="STOP")["test_worst_level"], "")

    def test_a_stop_of_primitives_is_real(self):
        child = Child(topic="/own_thresholds/clearance", duration=1.0, max_invalid=1.0, max_silence=5.0, moving_joints=[], min_stops=1,
                      max_false_stops=0.0)
        self.assertEqual(set(child.cases().values()), {""})
        self.assertEqual((child.metrics["false_stops"], child.metrics["open_stops"], child.metrics["time_held"]), (0.0, 0.0, 1.0))

    def test_a_node_that_cannot_start(self):
        child = Child(topic="/dead/clearance", minimum=0.0, duration=1.0, wait_time=10.0)
        program = roslib.packages.find_node("proximity_server", "proximity_server_node")[0]
        ended = subprocess.run([program, "__name:=dead", "_robot_description:=no_such_text"], capture_output=True, timeout=60)
        self.assertEqual(ended.returncode, 1)
        words = child.cases()["test_first_message"]
        self.assertRegex(words, r"^no message on /dead/clearance within the wait_time of 10 s; /dead ended with: .*no_such_text")

    def test_all_pairs_without_some(self):
        # Without base - ball, at 0.2 m, ball - block at 0.8487 m is the closest.
        left_out = [["ball", "base"]]
        cases = self.run_on("all_pairs", minimum=0.84, except_pairs=left_out)
        self.assertEqual(set(cases.values()), {""})
        words = self.run_on("all_pairs", minimum=0.85, except_pairs=left_out)["test_minimum"]
        self.assertRegex(words, r"above the minimum of 0\.85 m of all other pairs\. Worst: at [\d.]+ s block - ball: distance 0\.8486")

    def test_every_pair_below_is_named_though_the_message_lists_one(self):
        words = self.run_on("all_pairs", minimum=0.85)["test_minimum"]
        self.assertRegex(words, r"(?s)These 2 pairs, each at its worst:\n  ball - base: distance (0\.2|0\.1999|0\.2000).*\n  ball - block: "
                         r"distance 0\.8486")

    def test_a_pair_that_is_left_out_has_links(self):
        cases = self.run_on("all_pairs", minimum=0.1, except_pairs=[["bal", "base"]])
        self.assertEqual(list(cases), ["test_pairs"])
        self.assertIn("UNKNOWN_LINK: there is no link 'bal'", cases["test_pairs"])

    def test_a_link_that_does_not_exist(self):
        cases = self.run_on("all_pairs", minimum=0.1, pairs=[["base", "ball"], ["bal", "base"]])
        self.assertEqual(list(cases), ["test_pairs"])
        self.assertIn("UNKNOWN_LINK: there is no link 'bal': did you mean 'ball'", cases["test_pairs"])

    def test_a_link_without_geometry(self):
        cases = self.run_on("all_pairs", minimum=0.1, pairs=[["base", "slide"]])
        self.assertIn("NO_COLLISION_GEOMETRY", cases["test_pairs"])

    def test_a_pair_that_is_not_checked(self):
        cases = self.run_on("proximity_server", minimum=0.1, pairs=[["ball", "block"]])
        self.assertEqual(list(cases), ["test_pairs"])
        self.assertIn("PAIR_EXCLUDED", cases["test_pairs"])


if __name__ == "__main__":
    rospy.init_node("clearancetest_test")
    rostest.rosrun("proximity_server", "clearancetest", "__main__")
