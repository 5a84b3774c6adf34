#!/usr/bin/env python3
"""moveit_stream over real topics, from publishers whose classes are made from definitions, to a fake of the node."""

import os
import queue
import subprocess
import sys
import threading
import time
import unittest

import moveit_definitions
import roslib.packages
import rospy
import rostest
from moveit_messages import CLASSES, attached, box, scene
from proximity_server.msg import LinkInfo, ModelInfo, ObjectChange, QueryStatus
from proximity_server.srv import ApplyObjects, ApplyObjectsResponse

PATIENCE = 60.0  # [s] nothing takes this long unless it is broken
OK = QueryStatus()
ERROR, WARN = "[ERROR]", "[WARN]"  # as rospy prints them


def wait_for(condition, words):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, words
        rospy.rostime.wallsleep(0.01)


class FakeNode:
    """Offers apply_objects below `name`. Answers with what `statuses` holds, then with OK."""

    def __init__(self, name, statuses=(), start=1):
        self.requests, self.statuses, self.start = queue.Queue(), list(statuses), start
        self.service = rospy.Service(f"{name}/apply_objects", ApplyObjects, self.answer)

    def answer(self, request):
        changes = request.changes
        if not changes.changes and not changes.set_rules:
            return ApplyObjectsResponse(success=True, node_start=self.start)
        status = self.statuses.pop(0) if self.statuses else OK
        self.requests.put((changes, status))
        return ApplyObjectsResponse(success=status.code == QueryStatus.OK, status=status, node_start=self.start)

    def next(self):
        return self.requests.get(timeout=PATIENCE)[0]


class Stream:
    """A child process of moveit_stream, and publishers on its topics, which are in a namespace of its own."""

    def __init__(self, **parameters):
        self.name = f"/stream_{time.monotonic_ns()}"
        for name, value in {"server": f"{self.name}/node", **parameters}.items():
            rospy.set_param(f"{self.name}/moveit_stream/{name}", value)
        program = roslib.packages.find_node("proximity_server", "moveit_stream")[0]
        self.publishers = {}
        self.children = []
        self.log = []
        self.process = subprocess.Popen([program], env={**os.environ, "ROS_NAMESPACE": self.name}, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.PIPE, text=True)
        self.reader = threading.Thread(target=lambda: self.log.extend(iter(self.process.stderr.readline, "")))
        self.reader.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        processes = self.process, *self.children
        try:
            for process in processes:
                process.terminate()
            for process in processes:
                process.wait(timeout=PATIENCE)
        finally:
            for process in processes:
                process.kill()
        self.reader.join()
        self.process.stderr.close()
        for publisher in self.publishers.values():
            publisher.unregister()

    def publish(self, topic, message):
        if topic not in self.publishers:
            self.publishers[topic] = rospy.Publisher(f"{self.name}/{topic}", type(message), queue_size=1000)
            wait_for(lambda: self.publishers[topic].get_num_connections() > 0, f"nobody listens to {topic}")
        self.publishers[topic].publish(message)

    def publish_from_another_process(self, topic, what):
        """One message, by a publisher of its own: rospy has one type for each topic in a process."""
        program = os.path.join(os.path.dirname(os.path.realpath(__file__)), "moveit_messages.py")
        self.children.append(subprocess.Popen([sys.executable, program, f"{self.name}/{topic}", what]))

    def wait_for_log(self, level, *words):
        """The line of this level that has all words."""
        def found():
            return [line for line in list(self.log) if level in line and all(word in line for word in words)]

        wait_for(found, f"no log with {words}; there is {self.log}")
        return found()[0]


def model_of(*links):
    return ModelInfo(links=[LinkInfo(name=name) for name in links])


class MoveItStream(unittest.TestCase):
    def test_links_of_one_of_several_robots_are_called_as_the_node_calls_them(self):
        with Stream(robot="left") as stream:
            node = FakeNode(f"{stream.name}/node")
            stream.publish("attached_collision_object", attached("noetic", "bar"))  # waits for the model
            model = rospy.Publisher(f"{stream.name}/node/model_info", ModelInfo, queue_size=1, latch=True)
            model.publish(model_of("left/hand", "left/finger", "right/hand"))
            change, = node.next().changes
            self.assertEqual(("left/hand", ["left/finger"]), (change.link, change.touch_links))

    def test_a_robot_that_the_node_does_not_have_is_told(self):
        with Stream(robot="middle") as stream:
            model = rospy.Publisher(f"{stream.name}/node/model_info", ModelInfo, queue_size=1, latch=True)
            model.publish(model_of("left/hand"))
            stream.publish("collision_object", box("noetic", "bar"))
            stream.wait_for_log(ERROR, "collision_object", "parameter robot", "no robot 'middle'")

    def test_each_topic_of_each_version_becomes_changes(self):
        for version in moveit_definitions.VERSIONS:
            with Stream() as stream:
                node = FakeNode(f"{stream.name}/node")
                whole = scene(version, "shelf", is_diff=False)
                for topic, message, key in (("monitored_planning_scene", whole, "shelf"),
                                            ("collision_object", box(version, "box"), "box"),
                                            ("attached_collision_object", attached(version, "bar"), "bar"),
                                            ("planning_scene", scene(version, "table", is_diff=True), "table")):
                    stream.publish(topic, message)
                    change = node.next()
                    last = change.changes[-1]
                    x = (last.pose if version == "noetic" else last.primitive_poses[0]).position.x
                    self.assertEqual((ObjectChange.REPLACE, key, 1.5, [0.1, 0.2, 0.3]),
                                     (last.operation, last.id, x, list(last.primitives[0].dimensions)), topic)
                    self.assertEqual((("hand", ["finger"]) if key == "bar" else ("", [])), (last.link, last.touch_links))
                    self.assertEqual([("hand", key, True)] if "scene" in topic else [],
                                     [(rule.a, rule.b, rule.allowed) for rule in change.rules])
                stream.publish("planning_scene_world", scene(version, "floor", is_diff=True).world)
                self.assertEqual([(ObjectChange.REMOVE, "shelf"), (ObjectChange.REMOVE, "box"),
                                  (ObjectChange.REMOVE, "table"), (ObjectChange.REPLACE, "floor")],
                                 [(change.operation, change.id) for change in node.next().changes])
                self.assertEqual([], stream.log)

    def test_two_versions_on_one_topic_are_both_understood(self):
        with Stream() as stream:
            node = FakeNode(f"{stream.name}/node")
            stream.publish_from_another_process("collision_object", "melodic")
            self.assertEqual("box of melodic", node.next().changes[0].id)
            stream.publish("collision_object", box("noetic", "box"))
            self.assertEqual("box", node.next().changes[0].id)

    def test_another_type_on_a_topic_is_named_with_the_topic(self):
        with Stream() as stream:
            node = FakeNode(f"{stream.name}/node")
            stream.publish_from_another_process("collision_object", "string")
            stream.wait_for_log(ERROR, f"{stream.name}/collision_object", "std_msgs/String", "moveit_msgs/CollisionObject")
            stream.publish_from_another_process("collision_object", "foreign")
            stream.wait_for_log(ERROR, f"{stream.name}/collision_object", "field is missing")
            stream.publish("collision_object", box("noetic", "box"))
            self.assertEqual("box", node.next().changes[0].id)

    def test_a_malformed_object_is_named_and_the_next_one_is_taken(self):
        with Stream() as stream:
            node = FakeNode(f"{stream.name}/node")
            bad = box("noetic", "bad")
            bad.primitives[0].dimensions = [1.0]
            stream.publish("collision_object", bad)
            stream.wait_for_log(ERROR, "'bad'", "primitives[0].dimensions")
            stream.publish("collision_object", box("noetic", "good"))
            self.assertEqual(["good"], [change.id for change in node.next().changes])

    def test_what_comes_before_the_node_is_applied_when_it_is_there(self):
        with Stream() as stream:
            for number in range(5):
                stream.publish("collision_object", box("noetic", f"box {number}"))
            stream.wait_for_log(WARN, "does not answer", f"{stream.name}/node/apply_objects")
            node = FakeNode(f"{stream.name}/node")
            self.assertEqual([f"box {number}" for number in range(5)], [node.next().changes[0].id for _ in range(5)])

    def test_a_frame_that_tf_does_not_have_yet_is_waited_for(self):
        missing = QueryStatus(QueryStatus.TF_UNAVAILABLE, "frame camera is not in tf")
        with Stream(tf_timeout=1e6) as stream:
            node = FakeNode(f"{stream.name}/node", [missing] * 3)
            stream.publish("collision_object", box("noetic", "box", frame="camera"))
            self.assertEqual(["box"] * 4, [node.next().changes[0].id for _ in range(4)])
        with Stream(tf_timeout=0.0) as stream:
            node = FakeNode(f"{stream.name}/node", [missing] * 100)
            stream.publish("collision_object", box("noetic", "box", frame="camera"))
            stream.wait_for_log(ERROR, "TF_UNAVAILABLE", "frame camera is not in tf")

    def test_a_refusal_is_told_with_its_reason_and_the_scene_stays(self):
        refusal = QueryStatus(QueryStatus.INVALID_ARGUMENT, "object box: primitives[0]: the box has no volume")
        with Stream() as stream:
            node = FakeNode(f"{stream.name}/node", [refusal])
            stream.publish("collision_object", box("noetic", "box"))
            self.assertEqual("box", node.next().changes[0].id)
            stream.wait_for_log(ERROR, "INVALID_ARGUMENT", "object box: primitives[0]: the box has no volume")
            move = CLASSES["noetic"]["CollisionObject"](id="box", operation=3)
            stream.publish("collision_object", move)
            stream.wait_for_log(WARN, "'box'", "MOVE of what is not in the world")

    def test_a_node_that_was_restarted_is_given_the_objects_again(self):
        with Stream() as stream:
            node = FakeNode(f"{stream.name}/node")
            stream.publish("collision_object", box("noetic", "box"))
            stream.publish("collision_object", box("noetic", "seen", frame="camera"))
            self.assertEqual(["box", "seen"], [node.next().changes[0].id for _ in range(2)])
            node.start = 2
            self.assertEqual(["box"], [change.id for change in node.next().changes])
            stream.wait_for_log(ERROR, "gone", "seen")

    def test_a_change_that_a_restarted_node_refuses_is_tried_again_after_the_objects(self):
        with Stream() as stream:
            node = FakeNode(f"{stream.name}/node")
            stream.publish("collision_object", box("noetic", "box"))
            self.assertEqual("box", node.next().changes[0].id)
            stream.publish("collision_object", CLASSES["noetic"]["CollisionObject"](id="box", operation=3))
            self.assertEqual(ObjectChange.MOVE, node.next().changes[0].operation)
            node.start = 2
            node.statuses = [QueryStatus(QueryStatus.INVALID_ARGUMENT, "there is no object box")]
            stream.publish("collision_object", CLASSES["noetic"]["CollisionObject"](id="box", operation=3))
            operations = [node.next().changes[0].operation for _ in range(2)]
            while operations[-1] != ObjectChange.MOVE or ObjectChange.REPLACE not in operations:
                operations.append(node.next().changes[0].operation)
            self.assertIn(operations, ([ObjectChange.MOVE, ObjectChange.REPLACE, ObjectChange.MOVE],
                                       # The restart was noticed before the message came.
                                       [ObjectChange.REPLACE, ObjectChange.MOVE]))

    def test_a_signal_ends_it_while_it_logs(self):
        # Regression: rospy hangs if it handles a signal in a thread that is inside of rospy; four of five ends hung.
        for _ in range(3):
            with Stream() as stream:
                for number in range(500):
                    bad = box("noetic", f"bad {number}")
                    bad.primitives[0].dimensions = [1.0]
                    stream.publish("collision_object", bad)
                stream.wait_for_log(ERROR, "'bad ")

    def test_a_wrong_parameter_ends_it_with_its_name(self):
        for name, value in (("topics", ["colision_object"]), ("tf_timeout", -1), ("planing_frame", "odom")):
            with Stream(**{name: value}) as stream:
                self.assertEqual(1, stream.process.wait(timeout=PATIENCE))
                stream.wait_for_log("[FATAL]", f"parameter {name}")


if __name__ == "__main__":
    rospy.init_node("moveit_stream_test", argv=sys.argv)
    rostest.rosrun("proximity_server", "moveit_stream", MoveItStream)
