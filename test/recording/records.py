"""Records of a node for `clearance --replay`, without a node: poses of robots that are known on paper, and the levels that a node is to
have found there. They have no distances, so that a replay tells differences of levels only."""

import math
import pathlib
import xmlrpc.client

import genpy
import rosbag
import yaml
from dynamic_reconfigure.msg import BoolParameter, Config, DoubleParameter, IntParameter
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from proximity_server.msg import Clearance, Record, ShapeRef
import robots

CLEAR, WARN, STOP, COLLISION, INVALID = range(5)
TWO_ROBOTS = {name: {"description": f"/{name}/robot_description", "tf_prefix": name, "joint_states": f"/{name}/joint_states"}
              for name in ("left", "right")}
PART = {"id": "part", "pose": {"position": [1.5, 0, 0]}, "primitives": [{"type": "SPHERE", "dimensions": [0.1]}]}
TRAY = {"id": "tray", "frame": "cart", "pose": {"position": [0, 0, 0.3]}, "primitives": [{"type": "BOX", "dimensions": [0.4, 0.4, 0.02]}]}
HELD = {"id": "part", "link": "ball", "pose": {"position": [0.2, 0, 0]}, "primitives": [{"type": "SPHERE", "dimensions": [0.1]}]}
FLOOR = {"id": "floor", "planes": [{"coef": [0, 0, 1, 0.125]}]}
MESH = """<robot name="angle"><link name="angle"><collision><geometry><mesh filename="file://{}/angle.obj"/></geometry></collision></link>
<link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="angle"/><child link="ball"/><origin xyz="0 2.5 0.5"/><axis xyz="1 0 0"/>
<limit lower="0" upper="3" effort="1" velocity="1"/></joint></robot>"""


def pose(frame, x=0.0, y=0.0, z=0.0, turn=0.0):
    """`turn` [rad] is around z."""
    transform = TransformStamped(child_frame_id=frame)
    transform.transform.translation.x, transform.transform.translation.y, transform.transform.translation.z = x, y, z
    transform.transform.rotation.z, transform.transform.rotation.w = math.sin(0.5 * turn), math.cos(0.5 * turn)
    return transform


def gantry(x, y=0.0, lift=0.0, prefix="", base=0.0):
    """The poses of the gantry, see its URDF."""
    return [pose(prefix + "base", base), pose(prefix + "post", base, 0.0, lift), pose(prefix + "slide", base + x),
            pose(prefix + "ball", base + x, y, 0.0, 0.5 * math.pi)]


def gantry_texts():
    return tuple((robots.PLACES["GANTRY"] / f"gantry.{kind}").read_text() for kind in ("urdf", "srdf"))


def cycle(level, poses, deciding=(), age=0.0, text="", number=None):
    """`deciding`: two links, their distance, and the threshold."""
    clearance = Clearance(level=level)
    clearance.status.message = text
    clearance.tf_age = genpy.Duration.from_sec(age)
    clearance.minimum.lower_bound, clearance.minimum.upper_bound = -math.inf, math.inf
    if deciding:
        clearance.deciding.a.link, clearance.deciding.b.link, distance, clearance.deciding_threshold = deciding
        clearance.deciding.b.kind = ShapeRef.OBJECT if deciding[1] == "part" else ShapeRef.LINK
        clearance.deciding.distance = clearance.deciding.lower_bound = clearance.deciding.guaranteed = distance
    return clearance, poses, number


def settings_of(values):
    message = Config()
    for name, value in values.items():
        kinds = {bool: (message.bools, BoolParameter), int: (message.ints, IntParameter), float: (message.doubles, DoubleParameter)}
        entries, kind = kinds[type(value)]
        entries.append(kind(name=name, value=value))
    return message


def write(name, entries, parameters=None, settings=None, event="service", event_cycle=1, texts=None):
    """`entries` are cycles, 0.1 s apart, and lists of objects; `texts` are pairs of URDF and SRDF."""
    texts = texts or [gantry_texts()]
    dumped = xmlrpc.client.dumps((parameters,)) if parameters else ""
    record = Record(version=robots.version(), event=event, event_stamp=genpy.Time(100) + genpy.Duration.from_sec(0.1 * event_cycle),
                    parameters=dumped[dumped.find("<value>"):dumped.rfind("</value>") + 8].replace("\n", "") if dumped else "",
                    reference_frame="base", robot_descriptions=[urdf for urdf, _ in texts],
                    semantic_descriptions=[srdf for _, srdf in texts])
    with rosbag.Bag(f"{name}.bag", "w") as bag:
        def add(topic, message):
            """Readers sort by the time, so each message has a later one."""
            nonlocal time
            time += genpy.Duration(0, 1)
            bag.write(f"/proximity_server/{topic}", message, time)

        time, count = genpy.Time(100), 0
        add("record/robot", record)
        add("record/settings", settings_of(settings or {}))
        for entry in [[], *entries]:
            if isinstance(entry, list):
                add("record/objects", String(yaml.safe_dump({"objects": entry})))
                continue
            clearance, poses, number = entry
            count += 1
            clearance.cycle = number or count
            clearance.header.stamp = time = genpy.Time(100) + genpy.Duration(0, 100000000 * count)
            add("record/poses", TFMessage(poses))
            add("clearance", clearance)


def write_all():
    near = [cycle(CLEAR, gantry(0.5)), cycle(CLEAR, gantry(0.3)), cycle(WARN, gantry(0.24)), cycle(WARN, gantry(0.24, 0.0, 0.3)),
            cycle(STOP, gantry(0.21, 0.1), ("base", "ball", 0.01, 0.02)), cycle(COLLISION, gantry(0.19)), cycle(CLEAR, gantry(0.5))]
    write("thresholds", near, event="stop", event_cycle=5,
          parameters={"pair_stop_distance": [{"links": ["base", "ball"], "distance": 0.015}], "link_warn_distance": {"block": 0.9}})
    write("coarse", near, parameters={"joint_uncertainty": 0.008, "tolerance": 1e-3}, settings={"max_reported_pairs": 1, "threshold": 0.05})
    steps = (0.5, 0.22, 0.221, 0.2221, 0.25, 0.2515, 0.2521)
    write("hysteresis", [*(cycle(CLEAR, gantry(x)) for x in steps), cycle(STOP, gantry(0.221), number=20)],
          settings={"hysteresis": 0.002, "gradients": True})
    write("uncertain", near, event="stop", event_cycle=5,
          parameters={"joint_uncertainty": {"*": 0.001, "y_axis": 0.02}, "joint_frame_uncertainty": {"y_axis": {"angle": 0.01}},
                      "link_uncertainty": {"block": 0.005}})
    ages = [cycle(CLEAR, gantry(x), age=age) for x, age in ((0.5, 0.0), (0.3, 0.01), (0.3, 0.09), (0.3, 1.0), (0.3, -1.0))]
    write("latency", ages, parameters={"pose_latency": "limit", "message_latency": 0.02})
    write("late", ages, parameters={"pose_latency": "velocity", "max_acceleration": 2.0})
    write("objects", [cycle(CLEAR, gantry(0.5)), [PART], cycle(CLEAR, gantry(1.25)),
                      cycle(STOP, gantry(1.29), ("ball", "part", 0.01, 0.02)), [HELD], cycle(CLEAR, gantry(1.29)), [HELD, FLOOR, TRAY],
                      cycle(WARN, gantry(1.29) + [pose("cart", 1.0, 0.0, -0.35)]),
                      cycle(WARN, gantry(1.29) + [pose("cart", 2.0, 0.0, -0.35)]), cycle(INVALID, gantry(1.29), text="no cart"), [],
                      cycle(CLEAR, gantry(1.29))],
          event="stop", event_cycle=3, parameters={"object_uncertainty": {"part": 0.002}})
    write("padded", [cycle(CLEAR, gantry(0.5)), cycle(STOP, gantry(0.23), ("base", "ball", 0.01, 0.02))], event="stop", event_cycle=2,
          parameters={"default_padding": 0.01})
    write("coupled", [cycle(CLEAR, gantry(x, 0.6)) for x in (0.3, 0.5)], parameters={"joint_inequalities": ["x_axis + y_axis <= 1"]})
    write("unknown", [cycle(INVALID, [], text="nothing is known"), cycle(CLEAR, gantry(0.5)[:2]), cycle(CLEAR, gantry(0.5))])
    cell = gantry(1.2, 0.0, 0.0, "left/") + gantry(-1.09, 0.0, 0.0, "right/", 2.5)
    write("two_robots", [cycle(STOP, cell), [dict(HELD, link="left/ball")], cycle(COLLISION, cell)], texts=2 * [gantry_texts()],
          parameters={"robots": TWO_ROBOTS, "reference_frame": "world", "base_uncertainty": {"right": 0.001}})
    write("mesh", [cycle(CLEAR, [pose("angle"), pose("ball", x, 2.5, 0.5)], ("angle", "ball", x - 1.1, 0.05)) for x in (3.0, 1.14)],
          event_cycle=2, texts=[(MESH.format(pathlib.Path.cwd()), "")], parameters={"mesh_tolerance": 0.8, "link_padding": {"ball": 0.02}})
    write("no_parameters", [cycle(CLEAR, gantry(0.5))], parameters={"stop_distance": -1.0})
