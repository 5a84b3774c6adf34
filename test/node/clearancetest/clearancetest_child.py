"""Runs clearancetest as rostest does, and reads what it reports. Not a test by itself."""

import os
import subprocess
import tempfile
import time
import xml.etree.ElementTree as ElementTree

import geometry_msgs.msg
import roslib.packages
import rospy
import tf2_msgs.msg

PATIENCE = 60.0  # [s] nothing takes this long unless it is broken


def gantry_at(x, stamp):
    """The transforms of gantry.urdf at a position of its slide."""
    message = tf2_msgs.msg.TFMessage()
    for parent, child, distance in (("base", "slide", x), ("slide", "ball", 0.0), ("base", "post", 0.0)):
        transform = geometry_msgs.msg.TransformStamped(child_frame_id=child)
        transform.header.stamp, transform.header.frame_id = stamp, parent
        transform.transform.translation.x, transform.transform.rotation.w = distance, 1.0
        message.transforms.append(transform)
    return message


class Child:
    """clearancetest with these private parameters, started at once."""

    def __init__(self, **parameters):
        self.name = f"child_{time.monotonic_ns()}"
        for name, value in parameters.items():
            rospy.set_param(f"/{self.name}/{name}", value)
        self.folder = tempfile.TemporaryDirectory()
        self.file = os.path.join(self.folder.name, "result.xml")
        program = roslib.packages.find_node("proximity_server", "clearancetest")[0]
        self.process = subprocess.Popen([program, f"--gtest_output=xml:{self.file}", f"__name:={self.name}"],
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def cases(self):
        """{test case: words of its failure, or ""}; waits for the end, which has code 0 only if nothing failed."""
        output = self.output = self.process.communicate(timeout=PATIENCE)[0]
        suite = ElementTree.parse(self.file).getroot()
        self.metrics = {entry.get("name"): float(entry.get("value")) for entry in suite.iter("property")}
        found = {case.get("name"): "".join(part.text for part in case) for case in suite.iter("testcase")}
        failed = sum(1 for words in found.values() if words)
        assert found, output
        assert int(suite.get("failures")) == failed and int(suite.get("errors")) == 0, output
        assert (self.process.returncode == 0) == (failed == 0), output
        return found
