"""The running node: each question is a service with its request, or a state of the robot with the messages of the monitor.

The clock of all nodes is that of this program: it stands still between two states, and the monitor has one cycle at each. What
depends on the time that something takes is left out: the duration and the number of a cycle, the motion since the one before, and
budgets that end.

The node "watched" has a period of 10 s, of which its searches may take a quarter, so that they come to their end on any machine. Its
groups begin with their parameters, and its states may have velocities, for the look-ahead and the velocity scale. Its monitor gets
everything in one order: velocities and frames, then the transforms, then the time.
"""

import functools
import math
import queue
import re
import time
import unittest
import warnings
import xml.etree.ElementTree as ElementTree

import genpy
import rospkg
import rospy
import rostest
import tf2_msgs.msg
import yaml
from dynamic_reconfigure.encoding import decode_config, encode_config
from dynamic_reconfigure.srv import Reconfigure
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory

from proximity_server import msg, srv
from recording import Blocks
import robots

run = rostest.rosrun

PATIENCE = 60.0  # [s] nothing takes this long unless it is broken
SERVICES = {"minimum_distance": srv.MinimumDistance, "separation_axis": srv.SeparationAxis, "penetration_depth": srv.PenetrationDepth,
            "query_pairs": srv.QueryPairs, "query_points": srv.QueryPoints, "query_rays": srv.QueryRays,
            "query_configuration": srv.QueryConfiguration, "time_of_contact": srv.FirstContact,
            "query_trajectory": srv.QueryTrajectory, "prove_joint_box": srv.ProveJointBox,
            "apply_objects": srv.ApplyObjects, "enable_monitor": SetBool, "reload": Trigger,
            "set_parameters": Reconfigure}
ROBOTS = {"": ["/left", "/right"]}  # namespace of a node -> those of its robots, where there are several
MOTION = re.compile(", (closing|opening) [0-9]+ mm/s( by [^;]*)?")  # in the line of a level: since the cycle before
LEFT_OUT = {"computation_time", "cycle", "node_start", "seq", "lookahead"}


def missing(group):
    """Why a group cannot be asked here; empty if it can."""
    if group.startswith("two_robots") and rospkg.RosPack().get_manifest("robot_state_publisher").version in ("1.15.0", "1.15.1"):
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


def publisher(topic, kind):
    """One that has sent its message when publish() returns."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)  # rospy wants a queue
        return rospy.Publisher(topic, kind, queue_size=None)


class Joints:
    """Those of a robot: the node listens to its joint_states, and its robot_state_publisher, which makes the transforms, to its
    positions. Of several robots both listen to joint_states."""

    def __init__(self, namespace):
        self.states, self.positions = (publisher(f"{namespace}/{topic}", JointState) for topic in ("joint_states", "positions"))
        description = ElementTree.fromstring(rospy.get_param(f"{namespace}/robot_description"))
        self.names = [joint.get("name") for joint in description.findall("joint")
                      if joint.get("type") in ("revolute", "continuous", "prismatic") and joint.find("mimic") is None]

    def are_connected(self):
        return self.states.get_num_connections() + self.positions.get_num_connections() >= 2

    def message(self, stamp, positions, velocities):
        message = JointState(name=self.names, position=[float(positions.get(name, 0.0)) for name in self.names])
        if velocities is not None:
            message.velocity = [float(velocities.get(name, 0.0)) for name in self.names]
        message.header.stamp = stamp
        return message


class Node:
    """A node in its namespace, and the robots that it knows."""

    clock = None
    FIRST = now = start = rospy.Time(1000)

    @staticmethod
    @functools.lru_cache(maxsize=None)
    def of(namespace):
        return Node(namespace)

    def __init__(self, namespace):
        self.name = f"{namespace}/proximity_server"
        self.is_watched = namespace == "/watched"
        self.period = rospy.Duration.from_sec(1.0 / rospy.get_param(f"{self.name}/rate"))
        self.before = Node.now  # the time of the state before the latest
        self.robots = {name.strip("/"): Joints(name) for name in ROBOTS.get(namespace, [namespace])}
        topics = {"clearance": msg.Clearance, "constraints": msg.ConstraintRows}
        if self.is_watched:
            topics["collision_velocity_scale"] = Float64
        self.inboxes = {topic: queue.Queue() for topic in topics}
        self.answered = set()  # topics
        subscribers = [rospy.Subscriber(f"{self.name}/{topic}", kind, self.inboxes[topic].put) for topic, kind in topics.items()]
        self.latest = {}
        for topic, kind in (("objects", msg.ObjectList), ("model_info", msg.ModelInfo)):
            rospy.Subscriber(f"{self.name}/{topic}", kind, functools.partial(self.latest.__setitem__, topic))
        self.changes = rospy.Publisher(f"{self.name}/apply_objects", msg.ObjectChanges, queue_size=10)
        self.frames = publisher(f"{namespace}/tf", tf2_msgs.msg.TFMessage)
        self.commands = publisher(f"{namespace}/commands", JointTrajectory)
        self.stated = []  # names of parameters
        self.sees_changes = True  # the next change of objects has a cycle of its own
        for service in SERVICES:
            rospy.wait_for_service(f"{self.name}/{service}", PATIENCE)
        wait_until("robot_state_publisher", lambda: all(robot.are_connected() for robot in self.robots.values()))
        wait_until("the node's topics", self.changes.get_num_connections)
        wait_until("the monitor's topics", lambda: all(subscriber.get_num_connections() for subscriber in subscribers))
        for inbox in self.inboxes.values():
            with inbox.mutex:
                inbox.queue.clear()

    @functools.lru_cache(maxsize=None)
    def service(self, name):
        return rospy.ServiceProxy(f"{self.name}/{name}", SERVICES[name], persistent=True)

    def ask(self, name, fields):
        request = SERVICES[name]._request_class()
        genpy.message.fill_message_args(request, [fields])
        return self.service(name)(request)

    def received(self, topic):
        """The next message. A velocity scale has no stamp: it is that of the cycle whose clearance is the next one."""
        message = self.inboxes[topic].get(timeout=PATIENCE)
        if self.is_watched and topic == "clearance":
            self.scale = self.inboxes["collision_velocity_scale"].get(timeout=PATIENCE).data
        return message

    def next(self, topic):
        """The message at Node.now. A monitor forgets earlier answers when its clock stands still for two seconds: the bits of the
        next ones then depend on how busy the machine is."""
        while True:
            message = self.received(topic)
            if "the clock stands still" in message.status.message:
                if topic in self.answered:
                    raise unittest.SkipTest("this machine is too busy: two states are more than two seconds apart")
            elif message.header.stamp == Node.now:
                self.answered.add(topic)
                if topic == "clearance" and message.tf_age < rospy.Duration(0):
                    message.tf_age = rospy.Duration(0)  # the node looked by its wall time, before it knew the next time of the clock
                return message

    def messages(self, positions, velocities):
        """Of each robot."""
        for name, robot in self.robots.items():
            yield robot, robot.message(Node.now, positions.get(name, {}) if len(self.robots) > 1 else positions, velocities)

    def publish_frames(self, places):
        """Frames of tf that are no links, at their positions in that of the root."""
        message = tf2_msgs.msg.TFMessage()
        for child, (x, y, z) in places.items():
            message.transforms.append(transform("base", child, Node.now, x, y, z))
        wait_until("the node to listen to tf", self.frames.get_num_connections)
        self.frames.publish(message)

    def await_reading(self):
        """Waits until the node has read what was sent to it: the first of two calls may be read with it, the second one is not."""
        for _ in range(2):
            self.revision()

    def state(self, fields):
        """Places the robots at the next time, and lets the monitor look at them."""
        velocities, frames = fields.pop("velocities", None), fields.pop("frames", None)
        self.before = Node.now
        Node.now += self.period
        if frames:
            self.publish_frames(frames)
        messages = list(self.messages(fields, velocities))
        published = -math.inf

        def is_known():
            nonlocal published
            if time.monotonic() > published + 1.0:  # again: not all were connected
                for robot, message in messages:
                    robot.states.publish(message)
                self.await_reading()
                for robot, message in messages:
                    robot.positions.publish(message)
                published = time.monotonic()
            # The filter of the watched node may leave no pair.
            return self.ask("minimum_distance", {"stamp": fields_of(Node.now), "ignore_filter": self.is_watched}).success
        wait_until("tf", is_known)
        Node.clock.publish(Clock(Node.now))
        self.sees_changes = True
        return self.monitored()

    def monitored(self):
        """What the monitor says in its next cycle."""
        answer = Blocks()
        clearance, constraints = self.next("clearance"), self.next("constraints")
        answer.add("clearance", in_lines(clearance))
        if clearance.lookahead.state != msg.Lookahead.OFF:
            answer.add("lookahead", in_lines(clearance.lookahead))
        answer.add("constraints", in_lines(constraints))
        if self.is_watched:
            answer.add("velocity scale", shown(self.scale))
        return answer

    @functools.cached_property
    def defaults(self):
        """The live parameters at the start."""
        return self.set_live({})

    def set_live(self, values):
        config = decode_config(self.service("set_parameters")(encode_config(values)).config)
        return {name: value for name, value in config.items() if name != "groups"}

    def set_parameters(self, values):
        """Those that the questions behind this one are about: all others are what they were at the start."""
        for name in self.stated:
            rospy.delete_param(f"{self.name}/{name}")
        self.stated = [name for name in values if name not in self.defaults]
        for name in self.stated:
            rospy.set_param(f"{self.name}/{name}", values[name])
        answer = Blocks()
        live = {name: type(default)(values.get(name, default)) for name, default in self.defaults.items()}
        self.sees_changes = True
        self.answered.clear()  # the monitor begins anew
        try:
            self.set_live(live)
            self.period = rospy.Duration.from_sec(1.0 / live["rate"])
        except rospy.ServiceException as error:
            answer.add("live", str(error))
        answer.add("", in_lines(self.ask("reload", {})))
        return answer

    def command(self, fields):
        """A trajectory, as a controller gets it. The node takes it in the thread that answers changes of parameters."""
        wait_until("the monitor to listen", self.commands.get_num_connections)
        message = JointTrajectory()
        genpy.message.fill_message_args(message, [fields])
        self.commands.publish(message)
        for _ in range(2):
            self.set_live({})
        self.sees_changes = True
        return Blocks()

    def change(self, fields):
        """By the topic, which has no answer: the list of objects tells what came of it."""
        message = msg.ObjectChanges()
        genpy.message.fill_message_args(message, [fields])
        revision = self.revision()
        self.changes.publish(message)
        wait_until("another revision", lambda: self.revision() > revision)
        self.await_cycle(self.revision())
        return self.topic("objects")

    def apply(self, fields):
        before = self.revision()
        response = self.ask("apply_objects", fields)
        if response.revision != before:
            self.await_cycle(response.revision)
        return response

    def await_cycle(self, revision):
        """Of the watched node: it has one at once for the first change after a state."""
        while self.is_watched and self.sees_changes:
            self.sees_changes = self.received("clearance").objects_revision != revision

    def revision(self):
        return self.ask("apply_objects", {}).revision

    def topic(self, name):
        if name == "objects":
            revision = self.revision()
            wait_until("the list of objects", lambda: name in self.latest and self.latest[name].revision == revision)
        wait_until(name, lambda: name in self.latest)
        message = self.latest[name]
        if message.header.stamp == self.FIRST:
            message.header.stamp = rospy.Time()  # a node may be ready before the clock of this program, or after it
        answer = Blocks()
        answer.add("", in_lines(message))
        return answer

    def answer(self, question):
        name, _, text = question.partition(" ")
        for word, stamp in (("BEFORE", self.before), ("NOW", Node.now)):
            text = text.replace(word, str(fields_of(stamp)))
        fields = yaml.safe_load(text or "{}")
        asked = {"state": self.state, "change": self.change, "command": self.command, "parameters": self.set_parameters}
        if name in asked:
            return asked[name](fields)
        if name in ("objects", "model_info"):
            return self.topic(name)
        answer = Blocks()
        answer.add("", in_lines(self.apply(fields) if name == "apply_objects" else self.ask(name, fields)))
        return answer


def fields_of(stamp):
    return {"secs": stamp.secs, "nsecs": stamp.nsecs}


def transform(parent, child, stamp, x, y, z):
    stamped = TransformStamped(child_frame_id=child)
    stamped.header.stamp, stamped.header.frame_id = stamp, parent
    stamped.transform.translation.x, stamped.transform.translation.y, stamped.transform.translation.z = x, y, z
    stamped.transform.rotation.w = 1.0
    return stamped


def place_roots():
    """Where the two robots stand."""
    publisher = rospy.Publisher("/tf_static", tf2_msgs.msg.TFMessage, queue_size=1, latch=True)
    message = tf2_msgs.msg.TFMessage()
    for x, child in ((0.0, "left/base"), (2.5, "right/base")):
        message.transforms.append(transform("world", child, rospy.Time(), x, 0.0, 0.0))
    publisher.publish(message)
    return publisher


def prepare(options):
    rospy.init_node("recording", disable_rostime=True)
    Node.clock = rospy.Publisher("/clock", Clock, queue_size=10, latch=True)
    Node.clock.publish(Clock(Node.now))
    Node.roots = place_roots()


def answers(group, asked):
    node = Node.of("" if group.startswith("two_robots") else "/" + group.split("_")[0])
    Node.start = Node.now
    for question in asked:
        yield question, node.answer(question)
