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
    "GANTRY": SOURCE / "test/robots",
}
ENVIRONMENT = {**os.environ, **{name: str(path) for name, path in PLACES.items()}, "ROS_PACKAGE_PATH": f"{SOURCE}:{ROBOTS}"}


def missing(group):
    """Why a group cannot be asked here; empty if it can."""
    wants = any(name in group for name in ("panda", "pr2"))
    return "there is no ../shared/robots/example-robot-data" if wants and not EXAMPLES.exists() else ""


def text_of_header(header, name):
    """A text that the tests in C++ have as a raw string."""
    return re.search(name + r' = R"\((.*?)\)"', (SOURCE / "test" / header).read_text(), re.S)[1]


def version():
    """That of the package."""
    return re.search(r"<version>(.*)</version>", (SOURCE / "package.xml").read_text())[1]


# This is the mesh of a solid whose section is an L.
ANGLE = """v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nv 0 0 1\nv 3 0 1\nv 3 1 1\nv 1 1 1\nv 1 3 1\nv 0 3 1
f 1 4 3 2\nf 1 6 5 4\nf 7 8 9 10\nf 7 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n"""
