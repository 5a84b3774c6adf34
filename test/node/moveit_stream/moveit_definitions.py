"""The messages of moveit_msgs of two versions, written after their documented fields. Not a test by itself.

The classes are made from definitions as they are in a connection header; moveit_msgs is not installed.
"""

import genmsg
import genpy.dynamic
import geometry_msgs.msg
import sensor_msgs.msg
import shape_msgs.msg
import std_msgs.msg
import trajectory_msgs.msg

SEPARATOR = "=" * 80
VERSIONS = ("melodic", "noetic")

SHAPES = """
shape_msgs/SolidPrimitive[] primitives  # with a comment
geometry_msgs/Pose[] primitive_poses
shape_msgs/Mesh[] meshes
geometry_msgs/Pose[] mesh_poses
shape_msgs/Plane[] planes
geometry_msgs/Pose[] plane_poses
"""
OPERATIONS = """
byte ADD=0
byte REMOVE=1
byte APPEND=2
byte MOVE=3
byte operation
"""
COLLISION_OBJECT = {
    "melodic": "Header header\nstring id\nobject_recognition_msgs/ObjectType type" + SHAPES + OPERATIONS,
    "noetic": "Header header\ngeometry_msgs/Pose pose\nstring id\nobject_recognition_msgs/ObjectType type" + SHAPES +
              "string[] subframe_names\ngeometry_msgs/Pose[] subframe_poses" + OPERATIONS,
}
OTHERS = {
    "moveit_msgs/AttachedCollisionObject":
        "string link_name\nCollisionObject object\nstring[] touch_links\n"
        "trajectory_msgs/JointTrajectory detach_posture\nfloat64 weight\n",
    "moveit_msgs/RobotState":
        "sensor_msgs/JointState joint_state\nsensor_msgs/MultiDOFJointState multi_dof_joint_state\n"
        "AttachedCollisionObject[] attached_collision_objects\nbool is_diff\n",
    "moveit_msgs/AllowedCollisionEntry": "bool[] enabled\n",
    "moveit_msgs/AllowedCollisionMatrix":
        "string[] entry_names\nAllowedCollisionEntry[] entry_values\n"
        "string[] default_entry_names\nbool[] default_entry_values\n",
    "moveit_msgs/LinkPadding": "string link_name\nfloat64 padding\n",
    "moveit_msgs/LinkScale": "string link_name\nfloat64 scale\n",
    "moveit_msgs/ObjectColor": "string id\nstd_msgs/ColorRGBA color\n",
    "moveit_msgs/PlanningSceneWorld":
        "CollisionObject[] collision_objects\noctomap_msgs/OctomapWithPose octomap\n",
    "moveit_msgs/PlanningScene":
        "string name\nRobotState robot_state\nstring robot_model_name\n"
        "geometry_msgs/TransformStamped[] fixed_frame_transforms\nAllowedCollisionMatrix allowed_collision_matrix\n"
        "LinkPadding[] link_padding\nLinkScale[] link_scale\nObjectColor[] object_colors\nPlanningSceneWorld world\n"
        "bool is_diff\n",
    "object_recognition_msgs/ObjectType": "string key\nstring db\n",
    "octomap_msgs/Octomap": "Header header\nbool binary\nstring id\nfloat64 resolution\nint8[] data\n",
    "octomap_msgs/OctomapWithPose": "Header header\ngeometry_msgs/Pose origin\noctomap_msgs/Octomap octomap\n",
}
INSTALLED = (geometry_msgs.msg.Pose, geometry_msgs.msg.TransformStamped, sensor_msgs.msg.JointState,
             sensor_msgs.msg.MultiDOFJointState, shape_msgs.msg.Mesh, shape_msgs.msg.Plane, shape_msgs.msg.SolidPrimitive,
             std_msgs.msg.ColorRGBA, trajectory_msgs.msg.JointTrajectory)

# The md5 sums under which these messages are published: the definitions above are those of MoveIt, up to comments.
PUBLISHED = {
    ("melodic", "moveit_msgs/CollisionObject"): "568a161b26dc46c54a5a07621ce82cf3",
    ("melodic", "moveit_msgs/AttachedCollisionObject"): "3ceac60b21e85bbd6c5b0ab9d476b752",
    ("melodic", "moveit_msgs/PlanningScene"): "89aac6d20db967ba716cba5a86b1b9d5",
    ("noetic", "moveit_msgs/CollisionObject"): "dbba710596087da521c07564160dfccb",
    ("noetic", "moveit_msgs/AttachedCollisionObject"): "30199ef516f64c8bc1edb1084ce4584e",
}


def texts_of(version):
    """{type: its definition}, those of installed packages too."""
    texts = {"moveit_msgs/CollisionObject": COLLISION_OBJECT[version], **OTHERS}
    for each in INSTALLED:
        parts = each._full_text.split("\n" + SEPARATOR + "\n")
        texts[each._type] = parts[0]
        for part in parts[1:]:
            head, _, text = part.partition("\n")
            texts[head.replace("MSG: ", "", 1)] = text
    return texts


def definition(version, core):
    """The text of a type with all that it needs, as in a connection header."""
    texts = texts_of(version)
    context = genmsg.MsgContext.create_default()
    specs = {name: genmsg.msg_loader.load_msg_from_string(context, text, name) for name, text in texts.items()}
    needed = [core]
    for name in needed:  # grows
        for field in specs[name].types:
            bare = genmsg.msgs.bare_msg_type(field)
            bare = "std_msgs/Header" if bare == "Header" else bare
            if bare in texts and bare not in needed:
                needed.append(bare)
    return ("\n" + SEPARATOR + "\n").join([texts[core]] + [f"MSG: {name}\n{texts[name]}" for name in needed[1:]])


def classes_of(version):
    """{name without package: class}, for all messages of a version."""
    found = {}
    for core in ("moveit_msgs/PlanningScene", "moveit_msgs/CollisionObject", "moveit_msgs/AttachedCollisionObject",
                 "moveit_msgs/PlanningSceneWorld"):
        # Each top-level class has its own definition in full; nested ones are those of PlanningScene.
        made = genpy.dynamic.generate_dynamic(core, definition(version, core))
        for name, message_class in made.items():
            found.setdefault(name.rpartition("/")[2], message_class)
        found[core.rpartition("/")[2]] = made[core]
    return found
