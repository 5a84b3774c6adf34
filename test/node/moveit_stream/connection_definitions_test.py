#!/usr/bin/env python3
"""Messages are read by the definition in their connection header, and only if it is one."""

import io
import pathlib
import sys
import unittest

import moveit_definitions
import rospy
import rosunit

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "src/node/moveit_stream"))
from connection_definitions import Definitions, Unusable  # noqa: E402

CORE = "moveit_msgs/CollisionObject"
CLASSES = {version: moveit_definitions.classes_of(version) for version in moveit_definitions.VERSIONS}


def arrived(message, **header):
    """A message as a subscriber of AnyMsg gets it, with changes of its connection header."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    result = rospy.AnyMsg()
    result._buff = buffer.getvalue()
    result._connection_header = {"type": message._type, "md5sum": message._md5sum, "message_definition": message._full_text,
                                 **header}
    return result


def box(version="noetic"):
    return CLASSES[version]["CollisionObject"](id="box", operation=3)


class ConnectionDefinitions(unittest.TestCase):
    def setUp(self):
        self.definitions = Definitions()

    def expect_unusable(self, any_msg, *words):
        with self.assertRaises(Unusable) as refusal:
            self.definitions.read(any_msg, CORE)
        for each in words:
            self.assertIn(each, str(refusal.exception))

    def test_those_of_the_tests_are_the_published_ones(self):
        for (version, name), md5 in moveit_definitions.PUBLISHED.items():
            self.assertEqual(md5, CLASSES[version][name.rpartition("/")[2]]._md5sum, (version, name))

    def test_each_version_is_read_by_its_own(self):
        for version in moveit_definitions.VERSIONS * 2:
            message = self.definitions.read(arrived(box(version)), CORE)
            self.assertEqual(("box", 3, version == "noetic"), (message.id, message.operation, hasattr(message, "pose")))
        self.assertEqual(2, len(self.definitions.classes))

    def test_another_type_is_named(self):
        self.expect_unusable(arrived(box(), type="std_msgs/String"), "std_msgs/String", CORE)

    def test_a_header_without_a_definition_is_refused(self):
        self.expect_unusable(arrived(box(), message_definition=""), "no definition", CORE)

    def test_a_definition_that_is_not_that_of_the_md5_sum_is_refused(self):
        self.expect_unusable(arrived(box(), md5sum="0" * 32), box()._md5sum, "0" * 32)

    def test_a_definition_with_an_unknown_type_is_refused(self):
        self.expect_unusable(arrived(box(), message_definition="string id\nthings/Thing thing\n"), "Thing")

    def test_a_definition_that_holds_itself_is_refused(self):
        self.expect_unusable(arrived(box(), message_definition="moveit_msgs/CollisionObject[] inner\n"), CORE)

    def test_a_definition_that_would_run_code_is_refused(self):
        for line in ('string X="""+__import__("os").abort()+"""', "string X=a b", "int32 x)", "int32 x; import os",
                     "int32 x = ("):
            self.expect_unusable(arrived(box(), message_definition=f"{line}\nstring id\n"), "no field", line)

    def test_bytes_that_end_too_early_are_refused(self):
        any_msg = arrived(box())
        any_msg._buff = any_msg._buff[:-3]
        self.expect_unusable(any_msg, CORE)


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "moveit_connection_definitions_test", ConnectionDefinitions)
