"""The tools: each question is a command of the shell, in a folder with the files that prepare() makes."""

import hashlib
import io
import os
import pathlib
import random
import re
import subprocess

import numpy
import rosbag
import rospy
import rosunit
from sensor_msgs.msg import JointState

import robots
from recording import Blocks, digest

run = rosunit.unitrun

ANGLE = """v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nv 0 0 1\nv 3 0 1\nv 3 1 1\nv 1 1 1\nv 1 3 1\nv 0 3 1
f 1 4 3 2\nf 1 6 5 4\nf 7 8 9 10\nf 7 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n"""
MESHES = """<robot name="angle"><link name="angle"><collision><geometry><mesh filename="{}"/></geometry></collision></link>
<link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="angle"/><child link="ball"/><origin xyz="2.5 2.5 0.5"/><axis xyz="1 0 0"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>"""
THRESHOLDS = """stop_distance: 0.1
warn_distance: 3.2
pair_stop_distance: [{links: ["sled, left", base], distance: 0.9}, {links: [ball, "sled, left"], distance: 1.5}]
pair_warn_distance: [{links: [base, "sled, left"], distance: 1.7}, {links: [ball, "sled, left"], distance: 3}]
"""
SCHEDULE = """objects: [{id: part, pose: {position: [4, 0, 3]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}]
changes:
- {at: {row: 1}, operation: ATTACH, id: part, link: "sled, left", keep_pose: true}
- {at: {row: 3}, operation: DETACH, id: part}
- {at: {row: 4}, operation: MOVE, id: part, pose: {position: [2, 0, 2]}}
- {at: {row: 5}, operation: REPLACE, id: part, primitives: [{type: BOX, dimensions: [1, 1, 1]}]}
- {at: {row: 6}, operation: ADD, id: nut, planes: [{coef: [0, 0, 1, 1]}]}
- {at: {row: 8}, operation: REMOVE, id: "*"}
"""
TIMED = """objects: [{id: part, pose: {position: [4, 0, 3]}, primitives: [{type: CONE, dimensions: [0.2, 0.1]}]}]
changes:
- {at: {time: 1.5}, operation: ATTACH, id: part, link: "sled, left", keep_pose: true}
- {at: {time: 4}, operation: REMOVE, id: part}
"""


def table(header, count, lower, upper, seed):
    """CSV of random states."""
    source = random.Random(seed)
    rows = [",".join(repr(round(source.uniform(lower, upper), 6)) for _ in header) for _ in range(count)]
    return "\n".join([",".join(header), *rows, ""])


def write_bag(name):
    source = random.Random(5)
    with rosbag.Bag(name, "w") as bag:
        for i in range(30):
            stamp = rospy.Time(100 + i // 10, i % 10 * 100000000)
            position = source.uniform(-1, 2)
            bag.write("/joint_states", JointState(name=["slide"], position=[position]), stamp)
            bag.write("/others", JointState(name=["elbow"], position=[position]), stamp)


def prepare(options):
    robots.ENVIRONMENT["PATH"] = f"{options.programs}:{os.environ['PATH']}"
    arm = [f"left_{joint}" for joint in ("shoulder_pan", "shoulder_lift", "upper_arm_roll", "elbow_flex", "wrist_flex")]
    files = {
        "sliders.urdf": robots.text_of_header("tools/robot/two_sliders.h", "kTwoSliders"),
        "crossing.urdf": robots.text_of_header("tools/robot/crossing_sliders.h", "kCrossingSliders"),
        "crossing.srdf": robots.text_of_header("tools/robot/crossing_sliders.h", "kFaultySrdf"),
        "arm.urdf": robots.text_of_header("tools/states/arm.h", "kArm"),
        "angle.obj": ANGLE, "angle.urdf": MESHES.format("angle.obj"), "no_mesh.urdf": MESHES.format("absent.stl"),
        "thresholds.yaml": THRESHOLDS, "schedule.yaml": SCHEDULE, "timed.yaml": TIMED,
        "slide.csv": table(["slide"], 300, -1.2, 2, 7), "few.csv": table(["slide"], 10, -1.2, 2, 8),
        "arm.csv": table(arm, 12, -1, 0, 9), "time.csv": "time,slide\n0,0\n1,0.5\n2.5,-0.9\n3,-1.1\n5,2\n",
        "panda.csv": table([f"panda_joint{i}" for i in range(1, 8)], 8, -1.5, -0.1, 10),
        "broken.csv": "slide\n0\n1\nnan\n2\n", "quotes.csv": "slide\n\"0\n", "unknown.csv": "slied\n0\n", "empty.csv": "",
        "short.csv": "slide\n0\n0,1\n", "broken.urdf": "<robot name=\"x\"><link name=\"a\">",
    }
    for name, text in files.items():
        pathlib.Path(name).write_text(text)
    for path in sorted((robots.PLACES["CORPUS"] / "object_files").iterdir()):  # their first byte is for the fuzzer
        pathlib.Path(path.name).write_bytes(path.read_bytes()[1:])
    positions = numpy.random.default_rng(3).uniform(-1.2, 2, (200, 1))
    numpy.save("slide.npy", positions)
    numpy.save("slide_float.npy", numpy.asfortranarray(positions.astype(">f4")))
    numpy.savez("slide.npz", q=positions, joints=numpy.array(["slide"]))
    numpy.save("cube.npy", numpy.zeros((2, 2, 2)))
    pathlib.Path("cut_off.npy").write_bytes(pathlib.Path("slide.npy").read_bytes()[:300])
    write_bag("slide.bag")


# A tool prints this line only if the user's cache does not have the pieces of the mesh yet.
DECOMPOSING = re.compile(rb'^link ".*": mesh .*: decomposing \d+ triangles\n', re.MULTILINE)


def missing(group):
    """Why a group cannot be asked here; empty if it can."""
    if group == "clearance_second_opinion":
        asked = subprocess.run(["clearance", "sliders.urdf", "--zero", "--second-opinion", "fcl"], env=robots.ENVIRONMENT,
                               capture_output=True, text=True)
        return "this build has no FCL" if "this build has no FCL" in asked.stderr else ""
    return robots.missing(group)


def fingerprints():
    return {str(path): hashlib.sha256(path.read_bytes()).digest() for path in pathlib.Path().rglob("*") if path.is_file()}


def text_of(data):
    """Bytes as text; of a table of numpy its hash, its fields, and its rows."""
    if data.startswith(b"\x93NUMPY"):
        rows = numpy.load(io.BytesIO(data))
        return "\n".join([f"{len(data)} bytes, sha256 {digest(data)}", f"{rows.dtype.descr} {rows.shape}", *map(repr, rows.tolist())])
    try:
        return data.decode()
    except UnicodeDecodeError:
        return f"{len(data)} bytes, sha256 {digest(data)}"


def answers(group, asked):
    for command in asked:
        before = fingerprints()
        result = subprocess.run(["bash", "-c", command], env=robots.ENVIRONMENT, capture_output=True, timeout=120)
        answer = Blocks()
        answer.add("", text_of(result.stdout))
        answer.add("stderr", text_of(DECOMPOSING.sub(b"", result.stderr)))
        for name, fingerprint in sorted(fingerprints().items()):
            if before.get(name) != fingerprint:
                answer.add(f"file {name}", text_of(pathlib.Path(name).read_bytes()))
        answer.add("exit code", str(result.returncode))
        yield command, answer
