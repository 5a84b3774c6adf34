"""The tools: each question is a command of the shell, in a folder with the files that prepare() makes."""

import hashlib
import io
import os
import pathlib
import random
import re
import subprocess
import tempfile

import numpy
import rosbag
import rospy
import rosunit
from sensor_msgs.msg import JointState

import records
import robots
from recording import Blocks, digest

run = rosunit.unitrun

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

# Three cubes that slide along x, "b" 0.5 to 0.8 m before "a", and "c" as far before "b".
CUBES = """<robot name="cubes">
<link name="a"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="b"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="c"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<joint name="first" type="prismatic"><parent link="a"/><child link="b"/><origin xyz="0.5 0 0"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.3" effort="1" velocity="1"/></joint>
<joint name="second" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="0.5 0.0 0"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.3" effort="1" velocity="1"/></joint>
</robot>"""
LAMP = """<link name="lamp"><visual><geometry><sphere radius="{}"/></geometry></visual></link>
<joint name="weld" type="fixed"><parent link="a"/><child link="lamp"/></joint></robot>"""
FAULTS = {  # their names -> what stands in place of what, where it stands first
    "left_of_xacro": ("</robot>", '<gazebo reference="a"><mu1>${friction}</mu1></gazebo></robot>'),
    "number_of_xacro": ("0.5 0 0", "${length} 0 0"),
    "without_limits": ('lower="0" upper="0.3" effort="1" velocity="1"', 'lower="1" upper="-1" effort="1" velocity="1"'),
    "without_range": ('lower="0" upper="0.3" effort="1" velocity="1"', 'lower="0.1" upper="0.1" effort="1" velocity="0"'),
    "mimic": ('<origin xyz="0.5 0.0 0"/>', '<origin xyz="0.5 0.0 0"/><mimic joint="first" multiplier="-2" offset="0.1"/>'),
    "lamp": ("</robot>", LAMP.format(0.1)),
    "mark": ("</robot>", LAMP.format(0.005)),
    "visual": ('<link name="b">', '<link name="b"><visual><geometry><sphere radius="0.15"/></geometry></visual>'),
    "neighbours": ("0.5 0 0", "0.1 0 0"),
    "overlap": ("0.5 0 0", "-0.15 0 0"),
    "pocket": ("0.5 0.0 0", "-0.6 0 0"),
    "beam": ('<link name="c"><collision><geometry><box size="0.2 0.2 0.2"/>',
             '<link name="c"><collision><geometry><box size="4 0.1 0.1"/>'),
}
NEIGHBOURS = '<disable_collisions link1="a" link2="b" reason="Adjacent"/><disable_collisions link1="b" link2="c" reason="Adjacent"/>'
ENTRIES = {"": "", "_never": '<disable_collisions link1="a" link2="c" reason="Never"/>',
           "_decided": '<disable_collisions link1="a" link2="c" reason="User: c hangs in a pocket of a"/>',
           "_unknown": '<disable_collisions link1="a" link2="d" reason="Never"/>'}


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


def cubes():
    """Name -> text of the files about the three cubes."""
    files = {"cubes.urdf": CUBES}
    files.update((f"cubes_{name}.urdf", CUBES.replace(*fault, 1)) for name, fault in FAULTS.items())
    files.update((f"cubes{name}.srdf", f'<robot name="cubes">{NEIGHBOURS}{entry}</robot>') for name, entry in ENTRIES.items())
    return files


def prepare(options):
    robots.ENVIRONMENT["PATH"] = f"{options.programs}:{os.environ['PATH']}"
    robots.ENVIRONMENT["XDG_CACHE_HOME"] = CACHE.name
    arm = [f"left_{joint}" for joint in ("shoulder_pan", "shoulder_lift", "upper_arm_roll", "elbow_flex", "wrist_flex")]
    files = {
        "sliders.urdf": robots.text_of_header("tools/robot/two_sliders.h", "kTwoSliders"),
        "crossing.urdf": robots.text_of_header("tools/robot/crossing_sliders.h", "kCrossingSliders"),
        "crossing.srdf": robots.text_of_header("tools/robot/crossing_sliders.h", "kFaultySrdf"),
        "arm.urdf": robots.text_of_header("tools/states/arm.h", "kArm"),
        "angle.obj": robots.ANGLE, "angle.urdf": MESHES.format("angle.obj"), "no_mesh.urdf": MESHES.format("absent.stl"),
        "thresholds.yaml": THRESHOLDS, "schedule.yaml": SCHEDULE, "timed.yaml": TIMED,
        "slide.csv": table(["slide"], 300, -1.2, 2, 7), "few.csv": table(["slide"], 10, -1.2, 2, 8),
        "arm.csv": table(arm, 12, -1, 0, 9), "time.csv": "time,slide\n0,0\n1,0.5\n2.5,-0.9\n3,-1.1\n5,2\n",
        "panda.csv": table([f"panda_joint{i}" for i in range(1, 8)], 8, -1.5, -0.1, 10),
        "broken.csv": "slide\n0\n1\nnan\n2\n", "quotes.csv": "slide\n\"0\n", "unknown.csv": "slied\n0\n", "empty.csv": "",
        "short.csv": "slide\n0\n0,1\n", "broken.urdf": "<robot name=\"x\"><link name=\"a\">", **cubes(),
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
    records.write_all()


# The cache of meshes is empty at first, whatever the user's has. A tool prints this line for each mesh that is not in it.
CACHE = tempfile.TemporaryDirectory()
DECOMPOSING = re.compile(rb'^link ".*": mesh .*: decomposing \d+ triangles\n', re.MULTILINE)


def missing(group):
    """Why a group cannot be asked here; empty if it can."""
    if group.endswith("second_opinion"):
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
