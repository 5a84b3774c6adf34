"""The running node: each question is a service with its request, or a state of the robot with the messages of the monitor.

The clock of all nodes is that of this program: it stands still between two states, and the monitor has one cycle at each. What
depends on the time that something takes is left out: the duration and the number of a cycle, the motion since the one before, the
look-ahead and the velocity scale, which need velocities beside the transforms, and budgets that end.
"""

import functools
import queue
import re
import time
import unittest
import xml.etree.ElementTree as ElementTree

import genpy
import rospkg
import rospy
import rostest
import tf2_msgs.msg
import yaml
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from proximity_server import msg, srv
from recording import Blocks
import robots

run = rostest.rosrun

PATIENCE = 60.0  # [s] nothing takes this long unless it is broken
STEP = rospy.Duration(0, 100000000)  # the period of the monitor
SERVICES = {"minimum_distance": srv.MinimumDistance, "separation_axis": srv.SeparationAxis, "penetration_depth": srv.PenetrationDepth,
            "query_pairs": srv.QueryPairs, "query_configuration": srv.QueryConfiguration, "time_of_contact": srv.FirstContact,
            "query_trajectory": srv.QueryTrajectory, "prove_joint_box": srv.ProveJointBox,
            "apply_objects": srv.ApplyObjects}
ROBOTS = {"": ["/left", "/right"]}  # namespace of a node -> those of its robots, where there are several
MOTION = re.compile(", (closing|opening) [0-9]+ mm/s( by [^;]*)?")  # in the line of a level: since the cycle before
LEFT_OUT = {"computation_time", "cycle", "node_start", "seq", "lookahead"}


def missing(group):
    """Why a group cannot be asked here; empty if it can."""
    if group == "two_robots" and rospkg.RosPack().get_manifest("robot_state_publisher").version in ("1.15.0", "1.15.1"):
        return "robot_state_publisher before 1.15.2 has no tf_prefix"
    return robots.missing(group)


def wait_until(what, holds):
    deadline = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.005)


def shown(value):
    """In one line. A double as Python prints it: the shortest text that reads as the same."""
    if isinstance(value, genpy.Message):
        fields = ((name, getattr(value, name)) for name in value.__slots__ if name not in LEFT_OUT)
        return "{" + ", ".join(f"{name}: {shown(field)}" for name, field in fields) + "}"
    if isinstance(value, genpy.Duration):
        return f"{value.secs}.{value.nsecs:09}"
    if isinstance(value, genpy.Time):
        since = value - Node.start if value >= Node.start else value
        return f"{'start + ' if since is not value else ''}{since.secs}.{since.nsecs:09}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(shown, value)) + "]"
    if isinstance(value, str):
        return repr(MOTION.sub("", value))
    return repr(value) if not isinstance(value, bytes) else repr(list(value))


def in_lines(message):
    """A line for each field, and for each message of a list."""
    lines = []
    for name in message.__slots__:
        value = getattr(message, name)
        if name in LEFT_OUT:
            continue
        if isinstance(value, list) and value and isinstance(value[0], genpy.Message):
            lines += [f"{name}[{i}]: {shown(item)}" for i, item in enumerate(value)]
        else:
            lines.append(f"{name}: {shown(value)}")
    return "\n".join(lines)


class Joints:
    """Those of a robot, whose robot_state_publisher tells tf of them."""

    def __init__(self, namespace):
        self.publisher = rospy.Publisher(f"{namespace}/joint_states", JointState, queue_size=10)
        description = ElementTree.fromstring(rospy.get_param(f"{namespace}/robot_description"))
        self.names = [joint.get("name") for joint in description.findall("joint")
                      if joint.get("type") in ("revolute", "continuous", "prismatic") and joint.find("mimic") is None]

    def publish(self, stamp, positions):
        message = JointState(name=self.names, position=[float(positions.get(name, 0.0)) for name in self.names])
        message.header.stamp = stamp
        self.publisher.publish(message)


class Node:
    """A node in its namespace, and the robots that it knows."""

    clock = None
    now = start = rospy.Time(1000)

    @staticmethod
    @functools.lru_cache(maxsize=None)
    def of(namespace):
        return Node(namespace)

    def __init__(self, namespace):
        self.name = f"{namespace}/proximity_server"
        self.robots = {name.strip("/"): Joints(name) for name in ROBOTS.get(namespace, [namespace])}
        self.inboxes = {topic: queue.Queue() for topic in ("clearance", "constraints")}
        self.answered = set()  # topics
        for topic, kind in (("clearance", msg.Clearance), ("constraints", msg.ConstraintRows)):
            rospy.Subscriber(f"{self.name}/{topic}", kind, self.inboxes[topic].put)
        self.latest = {}
        for topic, kind in (("objects", msg.ObjectList), ("model_info", msg.ModelInfo)):
            rospy.Subscriber(f"{self.name}/{topic}", kind, functools.partial(self.latest.__setitem__, topic))
        self.changes = rospy.Publisher(f"{self.name}/apply_objects", msg.ObjectChanges, queue_size=10)
        for service in SERVICES:
            rospy.wait_for_service(f"{self.name}/{service}", PATIENCE)
        wait_until("robot_state_publisher", lambda: all(robot.publisher.get_num_connections() for robot in self.robots.values()))
        wait_until("the node's topics", self.changes.get_num_connections)

    @functools.lru_cache(maxsize=None)
    def service(self, name):
        return rospy.ServiceProxy(f"{self.name}/{name}", SERVICES[name], persistent=True)

    def ask(self, name, fields):
        request = SERVICES[name]._request_class()
        genpy.message.fill_message_args(request, [fields])
        return self.service(name)(request)

    def next(self, topic):
        """The message at Node.now. A monitor forgets earlier answers when its clock stands still for two seconds: the bits of the
        next ones then depend on how busy the machine is."""
        while True:
            message = self.inboxes[topic].get(timeout=PATIENCE)
            if "the clock stands still" in message.status.message:
                if topic in self.answered:
                    raise unittest.SkipTest("this machine is too busy: two states are more than two seconds apart")
            elif message.header.stamp == Node.now:
                self.answered.add(topic)
                if topic == "clearance" and message.tf_age < rospy.Duration(0):
                    message.tf_age = rospy.Duration(0)  # the node looked by its wall time, before it knew the next time of the clock
                return message

    def publish_state(self, positions):
        for name, robot in self.robots.items():
            robot.publish(Node.now, positions.get(name, {}) if len(self.robots) > 1 else positions)

    def state(self, positions):
        """Places the robots at the next time, and lets the monitor look at them."""
        Node.now += STEP
        self.publish_state(positions)
        published = time.monotonic()

        def is_known():
            nonlocal published
            response = self.ask("minimum_distance", {"stamp": {"secs": Node.now.secs, "nsecs": Node.now.nsecs}})
            if not response.success and time.monotonic() > published + 1.0:  # before all were connected
                self.publish_state(positions)
                published = time.monotonic()
            return response.success
        wait_until("tf", is_known)
        Node.clock.publish(Clock(Node.now))
        answer = Blocks()
        for topic in ("clearance", "constraints"):
            answer.add(topic, in_lines(self.next(topic)))
        return answer

    def change(self, fields):
        """By the topic, which has no answer: the list of objects tells what came of it."""
        message = msg.ObjectChanges()
        genpy.message.fill_message_args(message, [fields])
        revision = self.revision()
        self.changes.publish(message)
        wait_until("another revision", lambda: self.revision() > revision)
        return self.topic("objects")

    def revision(self):
        return self.ask("apply_objects", {}).revision

    def topic(self, name):
        if name == "objects":
            revision = self.revision()
            wait_until("the list of objects", lambda: name in self.latest and self.latest[name].revision == revision)
        wait_until(name, lambda: name in self.latest)
        answer = Blocks()
        answer.add("", in_lines(self.latest[name]))
        return answer

    def answer(self, question):
        name, _, text = question.partition(" ")
        fields = yaml.safe_load(text or "{}")
        if name == "state":
            return self.state(fields)
        if name == "change":
            return self.change(fields)
        if name in ("objects", "model_info"):
            return self.topic(name)
        answer = Blocks()
        answer.add("", in_lines(self.ask(name, fields)))
        return answer


def place_roots():
    """Where the two robots stand."""
    publisher = rospy.Publisher("/tf_static", tf2_msgs.msg.TFMessage, queue_size=1, latch=True)
    message = tf2_msgs.msg.TFMessage()
    for x, child in ((0.0, "left/base"), (2.5, "right/base")):
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = "world", child
        transform.transform.translation.x, transform.transform.rotation.w = x, 1.0
        message.transforms.append(transform)
    publisher.publish(message)
    return publisher


def prepare(options):
    rospy.init_node("recording", disable_rostime=True)
    Node.clock = rospy.Publisher("/clock", Clock, queue_size=10, latch=True)
    Node.clock.publish(Clock(Node.now))
    Node.roots = place_roots()


def answers(group, asked):
    node = Node.of("" if group == "two_robots" else "/" + group.split("_")[0])
    Node.start = Node.now
    for question in asked:
        yield question, node.answer(question)
