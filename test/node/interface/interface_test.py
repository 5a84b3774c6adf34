#!/usr/bin/env python3
"""Clients and recorded bags depend on the messages and services: none changes unnoticed."""

import importlib
import pathlib
import sys
import tempfile
import unittest

import genpy.dynamic
import rosbag
import rospkg
import rospy
import rosunit
from proximity_server.msg import QueryStatus
from rosbag import migration

SOURCE = pathlib.Path(__file__).resolve().parents[3]
RULES = SOURCE / "msg" / "migration.bmr"
WRITTEN = pathlib.Path(__file__).with_name("md5sums.txt")
ADVICE = """a message or service is not the one of md5sums.txt. A client or a bag of before then fails. If that is meant, add a line to
CHANGELOG.rst, a rule to msg/migration.bmr if it is a message (msg/README.md, "Changes of messages"), and the new sum to"""

RULE = '''
class update_status(MessageUpdateRule):
    old_type = new_type = "proximity_server/QueryStatus"
    old_full_text = """{}"""
    new_full_text = """{}"""
    order = 0
    migrated_types = []
    valid = True

    def update(self, old, new):
        new.code, new.message = old.code, "unknown"
'''


def md5sums():
    """{"msg/Clearance": md5 of all its fields, those of the messages in it included}, as roscpp and rosbag compare it."""
    sums = {}
    for kind in ("msg", "srv"):
        module = importlib.import_module(f"proximity_server.{kind}")
        for path in sorted((SOURCE / kind).glob(f"*.{kind}")):
            sums[f"{kind}/{path.stem}"] = getattr(module, path.stem)._md5sum
    return sums


class Interface(unittest.TestCase):
    maxDiff = None

    def test_messages_and_services_are_those_of_the_release(self):
        written = dict(line.split() for line in WRITTEN.read_text().splitlines())
        self.assertEqual(written, md5sums(), f"{ADVICE} {WRITTEN}")

    def test_package_xml_tells_rosbag_where_the_rules_are(self):
        package = rospkg.RosPack([str(SOURCE)]).get_manifest("proximity_server")
        self.assertEqual([str(RULES.relative_to(SOURCE))], package.get_export("rosbag", "migration_rule_file"))

    def test_a_rule_migrates_a_message_of_before(self):
        """As a release after this one does: the file has one rule more, for a message that had one field less."""
        if sys.version_info >= (3, 13):
            self.skipTest("rosbag 1.17.0 takes no rules with Python 3.13, whose locals() has not what exec() made")
        today = QueryStatus._full_text
        before = today.replace("string message", "#")
        self.assertNotEqual(today, before)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        old, new, rules = (str(pathlib.Path(folder.name, name)) for name in ("old.bag", "new.bag", "migration.bmr"))
        pathlib.Path(rules).write_text(RULES.read_text() + RULE.format(before, today))
        old_class = genpy.dynamic.generate_dynamic("proximity_server/QueryStatus", before)["proximity_server/QueryStatus"]
        with rosbag.Bag(old, "w") as bag:
            bag.write("status", old_class(code=QueryStatus.OVER_BUDGET), rospy.Time(1.0))
        self.assertEqual([], migration.fixbag2(migration.MessageMigrator([rules], plugins=False), old, new))
        with rosbag.Bag(new) as bag:
            (_, status, _), = bag.read_messages()
        self.assertEqual((QueryStatus._md5sum, QueryStatus.OVER_BUDGET, "unknown"), (status._md5sum, status.code, status.message))


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "interface_test", Interface)
