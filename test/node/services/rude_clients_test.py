#!/usr/bin/env python3
"""Clients that die in the middle of a call, and readers that never read, beside one that behaves."""

import io
import os
import queue
import socket
import struct
import time
import unittest
import urllib.parse
import xmlrpc.client

import geometry_msgs.msg
import rosgraph
import rosgraph.network
import rospy
import rostest
import tf2_msgs.msg
from proximity_server.msg import Clearance
from proximity_server.srv import MinimumDistance, MinimumDistanceRequest, QueryPairs, QueryPairsRequest

NODE = "/proximity_server"
DISTANCE = 0.2  # [m] between base and ball in gantry.urdf, with the ball at x = 0.4

# What is promised to the others.
LONGEST_SILENCE = 0.5  # [s] of ~clearance, whose period is 1 ms
LONGEST_CALL = 1.0     # [s]
CLEANED_UP = 5.0       # [s] until the node has closed what the rude ones left open

PATIENCE = 20.0  # [s] nothing takes this long unless it is broken


def transform(parent, child, x):
    result = geometry_msgs.msg.TransformStamped()
    result.header.stamp = rospy.Time.now()
    result.header.frame_id, result.child_frame_id = parent, child
    result.transform.translation.x, result.transform.rotation.w = x, 1.0
    return result


def wait_until(holds, patience=PATIENCE):
    deadline = time.monotonic() + patience
    while not holds():
        if time.monotonic() >= deadline:
            return False
        time.sleep(0.02)
    return True


def node_api():
    return xmlrpc.client.ServerProxy(rosgraph.Master(rospy.get_name()).lookupNode(NODE))


def open_files():
    """How many descriptors the node's process holds."""
    pid = node_api().getPid(rospy.get_name())[2]
    return len(os.listdir(f"/proc/{pid}/fd"))


def connect(host, port, header):
    """A TCPROS connection whose reader takes in as little as the kernel allows."""
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
    connection.settimeout(PATIENCE)
    connection.connect((host, port))
    if header:
        rosgraph.network.write_ros_handshake_header(connection, dict(header, callerid=rospy.get_name()))
        received(connection)  # the header of the node
    return connection


def received(connection):
    """One block: a header, or a message."""
    size, = struct.unpack("<I", received_bytes(connection, 4))
    return received_bytes(connection, size)


def received_bytes(connection, size):
    result = b""
    while len(result) < size:
        part = connection.recv(size - len(result))
        if not part:
            raise EOFError("the node has closed the connection")
        result += part
    return result


def connect_to_service(name, kind):
    api = urllib.parse.urlparse(rosgraph.Master(rospy.get_name()).lookupService(f"{NODE}/{name}"))
    header = {"service": f"{NODE}/{name}", "md5sum": kind._md5sum, "persistent": "1"} if kind else None
    return connect(api.hostname, api.port, header)


def connect_to_topic(name, kind):
    _, _, (_, host, port) = node_api().requestTopic(rospy.get_name(), f"{NODE}/{name}", [["TCPROS"]])
    return connect(host, port, {"topic": f"{NODE}/{name}", "md5sum": kind._md5sum, "type": kind._type})


def unsent(connection):
    """[byte] that wait on the node's side of a connection."""
    ports = [connection.getpeername()[1], connection.getsockname()[1]]
    with open("/proc/net/tcp") as table:
        rows = [line.split() for line in table][1:]
    return next(int(row[4].split(":")[0], 16) for row in rows
                if [int(end.split(":")[1], 16) for end in row[1:3]] == ports)


def serialized(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return struct.pack("<I", len(buffer.getvalue())) + buffer.getvalue()


def reset(connection):
    """Closes as a process does that was killed with unread data: the peer sees a reset."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    connection.close()


def base_and_ball():
    request = MinimumDistanceRequest()
    request.a.link, request.b.link = "base", "ball"
    return request


class RudeClients(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("rude_clients")
        tf = rospy.Publisher("/tf", tf2_msgs.msg.TFMessage, queue_size=10)

        def publish(_):
            tf.publish([transform("base", "slide", 0.4), transform("slide", "ball", 0.0), transform("base", "post", 0.0)])

        cls.robot = rospy.Timer(rospy.Duration(0.02), publish)
        cls.polite = rospy.ServiceProxy(f"{NODE}/minimum_distance", MinimumDistance)
        cls.polite.wait_for_service(PATIENCE)
        if not wait_until(lambda: cls.polite(base_and_ball()).success):
            raise AssertionError("the node does not start")

    @classmethod
    def tearDownClass(cls):
        cls.robot.shutdown()
        cls.robot.join()

    def setUp(self):
        self.open_before = open_files()
        self.arrivals = queue.Queue()
        self.reader = rospy.Subscriber(f"{NODE}/clearance", Clearance, self.arrivals.put)
        self.arrivals.get(timeout=PATIENCE)

    def tearDown(self):
        self.reader.unregister()
        # One more or less: connections of the polite ones come and go.
        self.assertTrue(wait_until(lambda: open_files() <= self.open_before + 1, CLEANED_UP),
                        f"{open_files()} open files, before {self.open_before}")

    def next_level(self, timeout):
        """A level that arrives from now on: those that wait since earlier are left out."""
        while not self.arrivals.empty():
            self.arrivals.get()
        return self.arrivals.get(timeout=timeout)

    def expect_service(self, seconds=0.5):
        """For so long every level arrives without a gap, every call is answered, and every number is right."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.assertAlmostEqual(self.next_level(LONGEST_SILENCE).minimum.distance, DISTANCE)
            start = time.monotonic()
            self.assertAlmostEqual(self.polite(base_and_ball()).pair.distance, DISTANCE)
            self.assertLess(time.monotonic() - start, LONGEST_CALL)

    def test_clients_that_say_nothing(self):
        silent = [connect_to_service("minimum_distance", None) for _ in range(50)]
        self.expect_service()
        for connection in silent:
            connection.close()

    def test_clients_that_die_in_the_middle_of_a_request(self):
        request = serialized(base_and_ball())
        for part in (0, 2, 4, len(request) // 2, len(request) - 1):
            for leave in (socket.socket.close, reset):
                connection = connect_to_service("minimum_distance", MinimumDistance)
                connection.sendall(request[:part])
                leave(connection)
        self.expect_service()

    def test_clients_that_die_before_the_answer(self):
        request = serialized(base_and_ball())
        for _ in range(50):
            for leave in (socket.socket.close, reset):
                connection = connect_to_service("minimum_distance", MinimumDistance)
                connection.sendall(request)
                leave(connection)
        self.expect_service()

    def test_a_client_that_asks_and_asks_and_never_reads(self):
        connection = connect_to_service("query_pairs", QueryPairs)
        request = serialized(QueryPairsRequest())
        connection.settimeout(0.5)
        with self.assertRaises(socket.timeout):  # in both directions there is no room any more
            while True:
                connection.sendall(request)
        self.expect_service()
        reset(connection)

    def test_a_subscriber_that_never_reads(self):
        connection = connect_to_topic("clearance", Clearance)
        before, now = -1, 0
        while before != now:  # until the kernel takes nothing in any more
            self.expect_service(0.5)
            before, now = now, unsent(connection)
        last = self.next_level(PATIENCE).cycle

        # What it finds when it reads at last has a gap: for the rest there was no room.
        cycles = []
        while not cycles or cycles[-1] < last:
            cycles.append(Clearance().deserialize(received(connection)).cycle)
        self.assertLess(len(cycles), cycles[-1] - cycles[0] + 1)
        reset(connection)


if __name__ == "__main__":
    rostest.rosrun("proximity_server", "rude_clients", RudeClients)
