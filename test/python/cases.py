"""What the tests of the module share: the module itself, robots, and a main() whose results ./dev test counts.

usage: <test>.py SOURCE_DIR MODULE_DIR ANSWERS_PROGRAM BUILD_DIR [--gtest_output=xml:FILE]

MODULE_DIR is empty where the build has no module, or no Python that can load it. Importing this file then ends the test:
its one case is skipped.
"""

import contextlib
import os
import pathlib
import sys
import tempfile
import time
import unittest
import warnings
import xml.etree.ElementTree as ElementTree

SOURCE = pathlib.Path(sys.argv[1]).resolve()
MODULE, ANSWERS, BUILD = sys.argv[2:5]
RESULTS = next((option.replace("--gtest_output=xml:", "") for option in sys.argv[5:]), None)
IS_SANITIZED = "instrumented_python" in sys.executable
SUITE = pathlib.Path(sys.argv[0]).stem


class Results(unittest.TextTestResult):
    """Also keeps each case for the file of results."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.suite = ElementTree.Element("testsuite", name=SUITE)
        self.begin = time.monotonic()

    def startTest(self, test):
        super().startTest(test)
        self.begin = time.monotonic()

    def case(self, test, outcome=None, text=""):
        name = test.id().replace("__main__.", "")
        seconds = f"{time.monotonic() - self.begin:.3f}"
        case = ElementTree.SubElement(self.suite, "testcase", classname=SUITE, name=name, time=seconds)
        if outcome:
            ElementTree.SubElement(case, outcome).text = text

    def addSuccess(self, test):
        super().addSuccess(test)
        self.case(test)

    def addFailure(self, test, error):
        super().addFailure(test, error)
        self.case(test, "failure", self.failures[-1][1])

    def addError(self, test, error):
        super().addError(test, error)
        self.case(test, "error", self.errors[-1][1])

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self.case(test, "skipped", reason)

    def addSubTest(self, test, subtest, error):
        super().addSubTest(test, subtest, error)
        if error:
            self.case(subtest, "failure", self._exc_info_to_string(error, test))


def repeats(usual):
    """How often a test repeats itself: a thirtieth of what is usual for a sanitizer, as in test/sanitized.h."""
    return max(1, usual // 30) if IS_SANITIZED else usual


def write(suite):
    if RESULTS:
        pathlib.Path(RESULTS).parent.mkdir(parents=True, exist_ok=True)
        ElementTree.ElementTree(suite).write(RESULTS)


def main():
    """Runs the test cases of the calling script, and ends the process."""
    tests = unittest.defaultTestLoader.loadTestsFromModule(sys.modules["__main__"])
    result = unittest.TextTestRunner(resultclass=Results, verbosity=2).run(tests)
    write(result.suite)
    sys.exit(0 if result.wasSuccessful() and result.testsRun else 1)


if not MODULE:
    reason = "there is no pybind11; or sanitizers are on, and there is no library of Python to link with them"
    print(f"skipped: {reason}", file=sys.stderr)
    skipped = ElementTree.Element("testsuite", name=SUITE)
    case = ElementTree.SubElement(skipped, "testcase", classname=SUITE, name="import_proximity")
    ElementTree.SubElement(case, "skipped").text = reason
    write(skipped)
    sys.exit(0)

sys.path.insert(0, MODULE)
import numpy  # noqa: E402
import proximity  # noqa: E402

DEMO = SOURCE / "config/demo"
EXAMPLE_ROBOTS = SOURCE.parent / "shared/robots/example-robot-data/robots"
PANDA = EXAMPLE_ROBOTS / "panda_description"


def package_roots():
    """Where meshes are looked for: in this package, and in those of the caller."""
    return [SOURCE, EXAMPLE_ROBOTS.parents[1], *os.environ.get("ROS_PACKAGE_PATH", "").split(":")]


@contextlib.contextmanager
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


class InFolder(unittest.TestCase):
    """A test case that has an empty folder."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def file(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path


def random_states(robot, shape, seed):
    """An array of states whose leading dimensions are those of the shape, or one dimension of that size."""
    leading = shape if isinstance(shape, tuple) else (shape,)
    return numpy.random.default_rng(seed).uniform(*robot.ranges.T, (*leading, len(robot.joints)))


def row_of(rows, pair):
    """The row of the pair of that number."""
    row, = rows[rows["pair"] == pair]
    return row


def load(urdf, srdf, **options):
    """A robot, without its warnings."""
    with no_warnings():
        return proximity.Robot(urdf, srdf, packages=package_roots(), **options)


def demo(**options):
    return load(DEMO / "robot.urdf", DEMO / "robot.srdf", **options)


def panda(**options):
    """Skips the test where the robot is not there."""
    if not PANDA.exists():
        raise unittest.SkipTest("there is no ../shared/robots/example-robot-data")
    return load(PANDA / "urdf/panda.urdf", PANDA / "srdf/panda.srdf", **options)


# The distance of base and arm is that of two points of a plane. The third ball, on the lift, goes away from both along z: another joint
# follows that of the lift.
BALLS = (SOURCE / "test/robots/balls.urdf").read_text()
ARM_AND_BASE = [("base", "arm")]
TURN, UP, UP_TWICE = range(3)  # the columns of q


def balls(**options):
    """All three pairs, those of neighbours too; without its warnings."""
    pairs = [("base", "arm"), ("base", "lamp"), ("arm", "lamp")]
    with no_warnings():
        return proximity.Robot.from_text(BALLS, **{"only_pairs": pairs, **options})
