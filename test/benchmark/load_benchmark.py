"""Measures the time until a robot is loaded and one state is answered: by `clearance` with an empty cache of meshes,
and again with what the first run left in it.

usage: load_benchmark.py CLEARANCE ROBOTS RESULT.json      (ROBOTS: the folder of the package example-robot-data)

The processor time counts; the wall time is that of this machine at this hour.
"""

import datetime
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time

ROBOTS = (
    ("Panda", "panda_description/urdf/panda.urdf"),
    ("UR5", "ur_description/urdf/ur5_robot.urdf"),
    ("PR2", "pr2_description/urdf/pr2.urdf"),
    ("Solo12", "solo_description/robots/solo12.urdf"),
    ("HyQ", "hyq_description/robots/hyq_no_sensors.urdf"),
    ("Laikago", "laikago_description/urdf/laikago.urdf"),
    ("Allegro hand", "allegro_hand_description/urdf/allegro_left_hand.urdf"),
    ("Kinova", "kinova_description/robots/kinova.urdf"),
    ("Romeo", "romeo_description/urdf/romeo.urdf"),
    ("B1 with Z1", "b1_description/urdf/b1-z1.urdf"),
)


def first_joint(urdf):
    """Returns the name of the first joint that moves: its column makes the one state."""
    return re.search(r'<joint\s+name="([^"]+)"\s+type="(?:revolute|continuous|prismatic)"', urdf.read_text())[1]


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(clearance, urdf, cache):
    """Returns the seconds of wall and processor time of one run."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache), "ROS_PACKAGE_PATH": str(urdf.parents[4])}
    before, start = processor_seconds(), time.monotonic()
    subprocess.run([clearance, urdf], input=f"{first_joint(urdf)}\n0\n", text=True, env=environment, check=True, capture_output=True)
    return {"wall": time.monotonic() - start, "processor": processor_seconds() - before}


def processor():
    models = re.findall(r"(?m)^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text())
    return models[0] if models else "unknown"


def main(clearance, robots, path):
    result = {"processor": processor(), "date": f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d}", "cores": os.cpu_count(),
              "robots": []}
    for name, urdf in ROBOTS:
        with tempfile.TemporaryDirectory() as cache:
            runs = [run(clearance, pathlib.Path(robots, "robots", urdf).resolve(), cache) for _ in range(2)]
        result["robots"].append({"robot": name, "first": runs[0], "again": runs[1]})
    with open(path, "w") as file:
        json.dump(result, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main(*sys.argv[1:4])
