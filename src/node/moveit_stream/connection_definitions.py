"""Reads messages of types that are not installed, by the definition in the header of the connection.

genpy makes the classes, as it does for rosbag. It writes Python source and runs it. A definition that holds anything
but names and numbers is therefore refused before: a publisher must not be able to run code in this process.
"""

import re

import genmsg
import genpy
import genpy.dynamic

LINE = re.compile(r"""MSG:\ \w+/\w+ | =+
                      | [A-Za-z][\w/]*(\[\d*\])? \s+ [A-Za-z]\w* (\s*=\s*[-+.\w]+)?""", re.VERBOSE | re.ASCII)


class Unusable(Exception):
    """The message cannot be read. The text is the reason."""


class Definitions:
    """The classes that were made so far."""

    def __init__(self):
        self.classes = {}

    def read(self, any_msg, wanted):
        """Returns the message in a rospy.AnyMsg, which must be of the type `wanted`. Raises Unusable if that fails.

        Limit: each definition that differs keeps a class and a module until the end of the process.
        """
        header = any_msg._connection_header
        message_class = self.class_of(header, wanted)
        try:
            return message_class().deserialize(any_msg._buff)
        except (genpy.DeserializationError, UnicodeError, OverflowError) as error:
            raise Unusable(f"the bytes are no {wanted}: {error}") from error

    def class_of(self, header, wanted):
        found, md5 = header.get("type"), header.get("md5sum")
        if found != wanted:
            raise Unusable(f"the type is {found}, wanted is {wanted}")
        definition = header.get("message_definition")
        if not definition:
            raise Unusable(f"the publisher sends no definition of {wanted} in its connection header")
        key = md5, definition
        if key not in self.classes:
            self.classes[key] = make_class(definition, wanted, md5)
        return self.classes[key]


def make_class(definition, wanted, md5):
    try:
        result = genpy.dynamic.generate_dynamic(wanted, without_comments(definition))[wanted]
    except (genmsg.InvalidMsgSpec, genmsg.MsgGenerationException, genmsg.MsgNotFound, KeyError, RecursionError,
            ValueError) as error:
        raise Unusable(f"the definition of {wanted} in the connection header cannot be used: {error}") from error
    if md5 != result._md5sum:
        raise Unusable(f"the definition of {wanted} in the connection header has the md5sum {result._md5sum}, but the header "
                       f"says {md5}")
    return result


def without_comments(definition):
    """Returns the definition without comments. Raises Unusable if it holds anything but names and numbers."""
    lines = [line.partition("#")[0].strip() for line in definition.splitlines()]
    for line in filter(None, lines):
        if not LINE.fullmatch(line):
            raise Unusable(f"the definition in the connection header has a line that is no field: {line[:80]!r}")
    return "\n".join(lines) + "\n"
