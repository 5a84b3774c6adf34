"""Measures the time until a robot is loaded and one state is answered: by `clearance` with an empty cache of meshes,
and again with what the first run left in it. Then measures random states, and counts the pieces in the cache.

usage: load_benchmark.py CLEARANCE ROBOTS RESULT.json      (ROBOTS: the folder of example-robot-data and public_robots)

The processor time counts; the wall time is that of this machine at this hour.
"""

import datetime
import json
import os
import pathlib
import re
import resource
import struct
import subprocess
import sys
import tempfile
import time

EXAMPLES, PUBLIC = "example-robot-data/robots", "public_robots"
ROBOTS = (
    ("Panda", f"{EXAMPLES}/panda_description/urdf/panda.urdf"),
    ("UR5", f"{EXAMPLES}/ur_description/urdf/ur5_robot.urdf"),
    ("UR10", f"{EXAMPLES}/ur_description/urdf/ur10_robot.urdf"),
    ("PR2", f"{EXAMPLES}/pr2_description/urdf/pr2.urdf"),
    ("Solo12", f"{EXAMPLES}/solo_description/robots/solo12.urdf"),
    ("HyQ", f"{EXAMPLES}/hyq_description/robots/hyq_no_sensors.urdf"),
    ("Laikago", f"{EXAMPLES}/laikago_description/urdf/laikago.urdf"),
    ("Allegro hand", f"{EXAMPLES}/allegro_hand_description/urdf/allegro_left_hand.urdf"),
    ("Kinova", f"{EXAMPLES}/kinova_description/robots/kinova.urdf"),
    ("Romeo", f"{EXAMPLES}/romeo_description/urdf/romeo.urdf"),
    ("B1 with Z1", f"{EXAMPLES}/b1_description/urdf/b1-z1.urdf"),
    ("Z1", f"{EXAMPLES}/z1_description/urdf/z1.urdf"),
    ("Go2", f"{EXAMPLES}/go2_description/urdf/go2.urdf"),
    ("Baxter", f"{EXAMPLES}/baxter_description/urdf/baxter.urdf"),
    ("iCub", f"{EXAMPLES}/icub_description/robots/icub.urdf"),
    ("Talos", f"{EXAMPLES}/talos_data/robots/talos_reduced.urdf"),
    ("Tiago", f"{EXAMPLES}/tiago_description/robots/tiago.urdf"),
    ("G1", f"{PUBLIC}/g1/g1.urdf"),
    ("Gen3", f"{PUBLIC}/gen3/gen3.urdf"),
    ("iiwa14", f"{PUBLIC}/iiwa14/iiwa14.urdf"),
    ("IRB 6640", f"{PUBLIC}/irb6640/irb6640.urdf"),
    ("Robotiq 3F", f"{PUBLIC}/robotiq_3f/robotiq_3f.urdf"),
    ("Stretch SE3", f"{PUBLIC}/stretch_se3/stretch_se3.urdf"),
    ("xArm7", f"{PUBLIC}/xarm7/xarm7.urdf"),
)
STATES = 1000


def first_joint(urdf):
    """Returns the name of the first joint that moves: its column makes the one state."""
    return re.search(r'<joint\s+name="([^"]+)"\s+type="(?:revolute|continuous|prismatic)"', urdf.read_text())[1]


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(clearance, urdf, robots, cache, *states):
    """Returns the seconds of wall and processor time of one run. `states`: options; without them the first joint is 0."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache), "ROS_PACKAGE_PATH": str(robots)}
    before, start = processor_seconds(), time.monotonic()
    subprocess.run([clearance, urdf, *states], input=None if states else f"{first_joint(urdf)}\n0\n", text=True, env=environment,
                   check=True, capture_output=True)
    return {"wall": time.monotonic() - start, "processor": processor_seconds() - before}


def pieces_of(cache):
    """Returns the most pieces of a mesh, the pieces of all different meshes, and the largest deviation [m]."""
    counts, deviations = [0], [0.0]
    for file in pathlib.Path(cache).rglob("*.pieces"):
        lines = file.read_text().split("\n")
        deviations.append(struct.unpack("d", struct.pack("Q", int(lines[4])))[0])
        counts.append(len(set(lines[9:9 + int(lines[8])])))
    return {"most": max(counts), "all": sum(counts), "deviation": max(deviations)}


def processor():
    models = re.findall(r"(?m)^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text())
    return models[0] if models else "unknown"


def main(clearance, robots, path):
    result = {"processor": processor(), "date": f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d}", "cores": os.cpu_count(),
              "robots": []}
    for name, urdf in ROBOTS:
        robot = pathlib.Path(robots, urdf).resolve()
        with tempfile.TemporaryDirectory() as cache:
            first, again, states = (run(clearance, robot, pathlib.Path(robots).resolve(), cache, *options)
                                    for options in ((), (), ("--sample", str(STATES))))
            pieces = pieces_of(cache)
        state = (states["processor"] - again["processor"]) / STATES
        result["robots"].append({"robot": name, "first": first, "again": again, "state": state, "pieces": pieces})
        print(f"{name}: {first['processor']:.2f} s, again {again['processor']:.2f} s, {pieces}", flush=True)
    with open(path, "w") as file:
        json.dump(result, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main(*sys.argv[1:4])
