"""The robots of the recording, and where they are."""

import os
import pathlib
import re

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DEMO = SOURCE / "config/demo"
ROBOTS = SOURCE.parent / "shared/robots"
EXAMPLES = ROBOTS / "example-robot-data/robots"
PLACES = {
    "DEMO": DEMO,
    "PANDA": EXAMPLES / "panda_description",
    "PR2": EXAMPLES / "pr2_description",
    "CORPUS": SOURCE / "test/fuzz/corpus",
    "GANTRY": SOURCE / "test/node",
}
ENVIRONMENT = {**os.environ, **{name: str(path) for name, path in PLACES.items()}, "ROS_PACKAGE_PATH": f"{SOURCE}:{ROBOTS}"}


def missing(group):
    """Why a group cannot be asked here; empty if it can."""
    wants = any(name in group for name in ("panda", "pr2"))
    return "there is no ../shared/robots/example-robot-data" if wants and not EXAMPLES.exists() else ""


def text_of_header(header, name):
    """A text that the tests in C++ have as a raw string."""
    return re.search(name + r' = R"\((.*?)\)"', (SOURCE / "test" / header).read_text(), re.S)[1]
