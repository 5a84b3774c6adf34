"""Translates MoveIt's messages about objects into changes for ~apply_objects. It needs no ROS master.

1. A MoveItScene knows the objects of MoveIt's scene after the messages so far: those in the world, and those that are
   attached to links.
2. A message is read by the rules of its type. Each of its operations becomes an ObjectChange, and changes a copy of the
   scene.
3. The caller applies the changes, and continues with the new scene; if the changes are refused, it keeps the old one.
   After a restart of the node, the scene makes changes that add all its objects again.

Source: the comments in moveit_msgs, and where they are not clear, planning_scene of Melodic and Noetic.
Messages of both versions are read. They differ in the field `pose` of CollisionObject, which only Noetic has:
* Without `pose`, the poses of shapes are in the frame of the header. With it they are relative to `pose`, and may be
  missing.
* With `pose`, if it is empty and there is a single shape, the pose of this shape is the pose of the object, as in
  Noetic.
* MOVE without `pose` has a new pose for every shape. With `pose`, it has poses of shapes only if they change, too.

Frames:  an object of the world stands still in the planning frame, even if the frame of its header moves later: the
         node looks up the newest transform once. MoveIt does not use stamps either. A leading '/' of a frame is
         dropped, as in MoveIt.
Pairs:   if the allowed-collision matrix has an entry for two names, this decides. Otherwise their defaults decide; if
         both names have a default, both must allow the pair, as AllowedCollisionMatrix.msg says. touch_links allow
         pairs in addition. An entry that is not symmetric allows nothing.

Deviations from MoveIt:
* A plane is solid below it (a x + b y + c z + d <= 0); in MoveIt it is a surface. So its normal has to point to the
  free side.
* APPEND places its shapes by its own header and `pose`, as Melodic does and as the comments say. Noetic uses the frame
  of the object, which is the same if `pose` is the pose of the object. APPEND does not move an attached object.
* In MoveIt the world may have an object with the id of an attached one. Here it is called "<id> (world)".
* Octomaps are not supported. link_padding and link_scale are not used: paddings are parameters of the node, and a
  message must not lower them. A warning tells that, and names the parameter.
* A frame that is an object of the scene, or a subframe of one, is refused, because tf does not know it.
* If one object is malformed, the whole message is ignored.
"""

import collections
import copy

from geometry_msgs.msg import Pose
from proximity_server.msg import ObjectChange, ObjectChanges, PairRule
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Header

# The operations of moveit_msgs/CollisionObject, the same in every version.
ADD, REMOVE, APPEND, MOVE = range(4)
OCTOMAP = "<octomap>"  # the id that MoveIt reserves

KINDS = (("primitives", "primitive_poses"), ("meshes", "mesh_poses"), ("planes", "plane_poses"))
DIMENSIONS = {SolidPrimitive.BOX: 3, SolidPrimitive.SPHERE: 1, SolidPrimitive.CYLINDER: 2, SolidPrimitive.CONE: 2}


class Refused(Exception):
    """The message cannot be read, so all of it is ignored. The text names the object and the field."""


class Entry(collections.namedtuple("Entry", "name link touch_links counts shapes place")):
    """An object in MoveIt's scene.

    name:   its id in the node
    link:   the link that holds it; "" if it is in the world
    counts: the number of its shapes of each of KINDS
    shapes: the fields of an ObjectChange with the shapes and a pose for each; None if their poses are not all known in
            one frame
    place:  the header and pose where it stays until the next change; None if they depend on transforms of the past
    """

    def moved(self, frame, header, pose):
        """The entry after a change that gives it a place. `frame` is the frame with which it moves."""
        return self._replace(place=(header, pose) if header.frame_id == frame else None)

    def with_more(self, change):
        """The entry after an APPEND."""
        shapes = None
        if self.shapes and self.place == (change.header, change.pose):
            more = shapes_of(change)
            shapes = {field: self.shapes[field] + more[field] for field in more}
        return self._replace(counts=added(self.counts, counts_of(change)), shapes=shapes)

    def recreated(self, frame):
        """The change that adds the object to a node without objects; None if its shapes or its place are not known."""
        if not self.shapes or not self.place:
            return None
        header, pose = self.place
        return ObjectChange(operation=ObjectChange.REPLACE, id=self.name, link=self.link, touch_links=self.touch_links,
                            frame="" if self.link else frame, header=header, pose=pose, **self.shapes)


# The content of a message: `changes` are ObjectChanges, maybe none, and `scene` is MoveIt's scene after the message.
Translation = collections.namedtuple("Translation", "changes warnings scene")


class MoveItScene:
    """The objects in MoveIt's scene, and its rules for pairs.

    planning_frame: the tf frame in which MoveIt's world rests; "" for the reference frame of the node
    links:          the names in the node of those links that have another name in MoveIt
    """

    def __init__(self, planning_frame=""):
        self.planning_frame = planning_frame
        self.links = {}
        self.world, self.attached = {}, {}  # id: Entry
        self.rules = None  # [PairRule]; None if MoveIt has not sent a matrix
        self.given_warnings = set()  # warnings that were given and are not repeated

    def translate(self, message, read):
        """Translates a message by `read`, one of the methods in TOPICS. This scene stays as it is. May raise
        Refused."""
        reader = MessageReader(self)
        try:
            read(reader, message)
        except (AttributeError, TypeError) as error:
            raise Refused(f"a field is missing, or has another type: {error}") from error
        return Translation(reader.changes, reader.warnings, reader.scene)

    def set_link_names(self, links):
        """Sets the names in the node: links[name] is the name of MoveIt's link `name`, and of its frame."""
        self.links = links
        self.planning_frame = links.get(self.planning_frame, self.planning_frame)

    def recreated(self):
        """(ObjectChanges that make the scene in a node without objects, names of the objects whose place is not known).

        The latter are removed from this scene.
        """
        changes = ObjectChanges(set_rules=self.rules is not None, rules=self.rules or [])
        lost = []
        for entries in (self.world, self.attached):
            for key, entry in list(entries.items()):
                change = entry.recreated(self.planning_frame)
                if change:
                    changes.changes.append(change)
                else:
                    lost.append(entries.pop(key).name)
        return changes, lost


class MessageReader:
    """Reads one message: collects its changes and warnings, and applies them to a copy of the scene."""

    def __init__(self, scene):
        self.scene = copy.copy(scene)
        self.scene.world, self.scene.attached = dict(scene.world), dict(scene.attached)
        self.scene.given_warnings = set(scene.given_warnings)
        self.changes = ObjectChanges()
        self.warnings = []

    def warn(self, words):
        self.warnings.append(words)

    def warn_once(self, words):
        if words not in self.scene.given_warnings:
            self.scene.given_warnings.add(words)
            self.warn(words)

    def change(self, operation, name, **fields):
        result = ObjectChange(operation=operation, id=name, **fields)
        self.changes.changes.append(result)
        return result

    def replace(self, name, message, frame="", link="", touch_links=()):
        """Makes an object from the shapes of a CollisionObject. May raise Refused."""
        change = self.change(ObjectChange.REPLACE, name, frame=frame, link=link, touch_links=list(touch_links),
                             **self.placed_shapes(message))
        entry = Entry(name, link, change.touch_links, counts_of(change), shapes_of(change), None)
        return entry.moved(link or frame, change.header, change.pose)

    # --- One object.

    def collision_object(self, message):
        """Reads a CollisionObject: an operation on an object of the world."""
        check_id(message)
        operations = {ADD: self.add, APPEND: self.append, MOVE: self.move, REMOVE: self.remove}
        if message.operation not in operations:
            raise Refused(f"object '{message.id}': operation {message.operation} is unknown")
        operations[message.operation](message)

    def add(self, message):
        entry = self.scene.world.get(message.id)
        name = entry.name if entry else self.name_in_world(message.id)
        self.scene.world[message.id] = self.replace(name, message, frame=self.scene.planning_frame)

    def name_in_world(self, key):
        attached = self.scene.attached.get(key)
        return f"{key} (world)" if attached and attached.name == key else key

    def append(self, message):
        entry = self.scene.world.get(message.id)
        if entry is None:
            self.add(message)
            return
        change = self.change(ObjectChange.APPEND, entry.name, **self.placed_shapes(message))
        self.scene.world[message.id] = entry.with_more(change)

    def move(self, message):
        entry = self.scene.world.get(message.id)
        if entry is None:
            self.warn(f"object '{message.id}': MOVE of what is not in the world has no effect")
            return
        given = tuple(len(getattr(message, poses)) for _, poses in KINDS)
        if given != entry.counts and (any(given) or not has_pose(message)):
            raise Refused(f"object '{message.id}': MOVE has {listed(given, 1)} for {listed(entry.counts, 0)}")
        if any(counts_of(message)):
            self.warn(f"object '{message.id}': MOVE does not read the shapes in its message")
        poses = {poses: getattr(message, poses) for _, poses in KINDS if getattr(message, poses)}
        change = self.change(ObjectChange.MOVE, entry.name, frame=self.scene.planning_frame, pose=pose_of(message),
                             header=self.header_of(message), **poses)
        shapes = entry.shapes and {**entry.shapes, **poses}
        self.scene.world[message.id] = entry._replace(shapes=shapes).moved(change.frame, change.header, change.pose)

    def remove(self, message):
        """Reads a REMOVE: it removes one object of the world, or with the id "" all of them. Attached objects stay."""
        if not message.id:
            self.remove_world()
        elif message.id in self.scene.world:
            self.change(ObjectChange.REMOVE, self.scene.world.pop(message.id).name)
        elif message.id not in self.scene.attached:
            # The node may have got this object before this process was started.
            self.change(ObjectChange.REMOVE, message.id)

    def remove_world(self):
        for entry in self.scene.world.values():
            self.change(ObjectChange.REMOVE, entry.name)
        self.scene.world.clear()

    # --- One attached object.

    def attached_object(self, message):
        """Reads an AttachedCollisionObject: it attaches one object, or detaches one or many."""
        check_id(message.object)
        operation = message.object.operation
        if operation in (ADD, APPEND):
            if not message.link_name:
                raise Refused(f"attached object '{message.object.id}': link_name is empty")
            self.attach(message)
        elif operation == REMOVE:
            self.detach(message)
        elif operation == MOVE:
            self.warn(f"attached object '{message.object.id}': MOVE has no effect on attached objects, as in MoveIt")
        else:
            raise Refused(f"attached object '{message.object.id}': operation {operation} is unknown")

    def attach(self, message):
        entry = self.scene.attached.get(message.object.id)
        if message.object.operation == ADD and not any(counts_of(message.object)):
            self.attach_from_world(message)
        elif message.object.operation == APPEND and entry:
            self.append_to_attached(message, entry)
        else:
            self.attach_shapes(message)

    def attach_from_world(self, message):
        """Reads an ADD without geometry: from now on the link holds an object of the world, which stays where it is."""
        key = message.object.id
        if key not in self.scene.world:
            self.warn(f"attached object '{key}': it has no shapes, and there is none of this id in the world: no effect")
            return
        if key in self.scene.attached:
            self.change(ObjectChange.REMOVE, self.scene.attached.pop(key).name)
        entry = self.scene.world.pop(key)
        link, touch_links = self.in_node(message.link_name), self.all_in_node(message.touch_links)
        self.change(ObjectChange.ATTACH, entry.name, keep_pose=True, link=link, touch_links=touch_links)
        self.scene.attached[key] = entry._replace(link=link, touch_links=touch_links, place=None)

    def append_to_attached(self, message, entry):
        key = message.object.id
        link, touch_links = self.in_node(message.link_name), self.all_in_node(message.touch_links)
        if entry.link != link:
            raise Refused(f"attached object '{key}': link_name of APPEND is '{link}', but '{entry.link}' holds it")
        if key in self.scene.world:
            self.change(ObjectChange.REMOVE, self.scene.world.pop(key).name)
        change = self.change(ObjectChange.APPEND, entry.name, touch_links=touch_links, **self.placed_shapes(message.object))
        self.scene.attached[key] = entry.with_more(change)._replace(touch_links=entry.touch_links + touch_links)

    def attach_shapes(self, message):
        """Reads an ADD, or an APPEND to an id that is not attached: it replaces the objects of this id."""
        key = message.object.id
        entry, in_world = self.scene.attached.get(key), self.scene.world.pop(key, None)
        if entry and in_world:
            self.change(ObjectChange.REMOVE, in_world.name)
        name = entry.name if entry else in_world.name if in_world else key
        self.scene.attached[key] = self.replace(name, message.object, link=self.in_node(message.link_name),
                                                touch_links=self.all_in_node(message.touch_links))

    def detach(self, message):
        """Reads a REMOVE: it puts an object back into the world; with the id "" all objects of the link, or of all
        links if link_name is "", too."""
        key, link = message.object.id, self.in_node(message.link_name)
        if key:
            entry = self.scene.attached.get(key)
            if entry and link and link != entry.link:
                self.warn(f"attached object '{key}': '{link}' does not hold it, but '{entry.link}' does: no effect")
            elif entry:
                self.release(key)
            return
        for key in [key for key, entry in self.scene.attached.items() if not link or entry.link == link]:
            self.release(key)

    def release(self, key):
        entry = self.scene.attached.pop(key)
        if key in self.scene.world:
            self.warn(f"attached object '{key}': the world has one of this id, so the one that was attached is gone, as in "
                      "MoveIt")
            self.change(ObjectChange.REMOVE, entry.name)
            return
        self.change(ObjectChange.DETACH, entry.name, frame=self.scene.planning_frame)
        self.scene.world[key] = entry._replace(link="", touch_links=[], place=None)

    # --- Whole scenes.

    def planning_scene(self, message):
        """Reads a PlanningScene: either a diff to the present scene, or a new scene."""
        matrix = message.allowed_collision_matrix
        self.robot_state(message)
        if not message.is_diff or matrix.entry_names or matrix.default_entry_names:
            self.set_rules(matrix)
        self.refuse_link_sizes(message)
        if not message.is_diff:
            self.remove_world()
        self.world_objects(message.world)

    def monitored_scene(self, message):
        """Reads a PlanningScene of move_group, which sends the whole scene first, and then diffs."""
        missed = "monitored_planning_scene began with a diff: what MoveIt's scene held before is not known here"
        if message.is_diff:
            self.warn_once(missed)
        self.planning_scene(message)
        self.scene.given_warnings.add(missed)

    def replace_world(self, message):
        """Reads a PlanningSceneWorld: it replaces the objects of the world. Attached objects stay."""
        self.remove_world()
        self.world_objects(message)

    def world_objects(self, world):
        for each in world.collision_objects:
            self.collision_object(each)
        if world.octomap.octomap.data:
            self.warn_once("octomaps are not supported: the octomap in MoveIt's scene is not checked")

    def robot_state(self, message):
        """Reads PlanningScene.robot_state: its attached objects replace the present ones, or are added to them."""
        state = message.robot_state
        has_joints = state.joint_state.name or state.multi_dof_joint_state.joint_names
        is_diff = getattr(state, "is_diff", message.is_diff)  # Groovy does not have this field
        # In a diff, MoveIt ignores a state without joints, but attaches its objects.
        if not is_diff and (has_joints or not message.is_diff):
            for entry in self.scene.attached.values():
                self.change(ObjectChange.REMOVE, entry.name)
            self.scene.attached.clear()
        for each in state.attached_collision_objects:
            if each.object.operation != ADD and not is_diff:
                self.warn(f"attached object '{each.object.id}': operation {each.object.operation} wants robot_state.is_diff: "
                          "no effect, as in MoveIt")
            else:
                self.attached_object(each)

    def refuse_link_sizes(self, message):
        padded = {each.link_name: each.padding for each in message.link_padding if each.padding}
        if padded:
            words = ", ".join(f"{link}: {padding:g}" for link, padding in sorted(padded.items()))
            self.warn_once("link_padding is not taken over from MoveIt; the parameter of the node would be link_padding: "
                           f"{{{words}}}")
        scaled = sorted(each.link_name for each in message.link_scale if each.scale != 1.0)
        if scaled:
            self.warn_once(f"link_scale is not supported: {', '.join(scaled)} keep the size of the URDF")

    def set_rules(self, matrix):
        self.changes.set_rules = True
        rules = [PairRule(self.in_node(rule.a), self.in_node(rule.b), rule.allowed) for rule in rules_of(matrix)]
        self.changes.rules = self.scene.rules = rules

    # --- Fields.

    def in_node(self, name):
        """The name in the node of a link or frame that has this name in MoveIt."""
        return self.scene.links.get(name, name)

    def all_in_node(self, names):
        return [self.in_node(name) for name in names]

    def placed_shapes(self, message):
        """The fields of an ObjectChange for shapes with their poses, and for the pose of the object. May raise
        Refused."""
        check_shapes(message)
        fields = {name: getattr(message, name) for kind in KINDS for name in kind}
        fields["header"], fields["pose"] = self.header_of(message), pose_of(message)
        if has_pose(message) and sum(counts_of(message)) == 1 and is_empty(message.pose):
            for _, poses in KINDS:
                if fields[poses]:
                    fields["pose"], fields[poses] = fields[poses][0], []
        return fields

    def header_of(self, message):
        frame = message.header.frame_id
        frame = frame[1:] if frame.startswith("/") else frame
        for key in (frame, frame.partition("/")[0]):
            if key in self.scene.world or key in self.scene.attached:
                raise Refused(f"object '{message.id}': header.frame_id '{frame}' is an object's frame, which tf does not know")
        return Header(frame_id=self.in_node(frame) or self.scene.planning_frame)


def check_id(message):
    if message.id == OCTOMAP:
        raise Refused(f"object '{OCTOMAP}': id is reserved")
    if message.id == "*" or not message.id and message.operation != REMOVE:
        raise Refused(f"object '{message.id}': id is no name")


def check_shapes(message):
    if not any(counts_of(message)):
        raise Refused(f"object '{message.id}': it has no shapes")
    for kind, poses in KINDS:
        shapes, given = len(getattr(message, kind)), len(getattr(message, poses))
        if given != shapes and (given or not has_pose(message)):
            raise Refused(f"object '{message.id}': {poses} has {given} poses for {shapes} {kind}")
    for index, primitive in enumerate(message.primitives):
        wanted = DIMENSIONS.get(primitive.type)
        if wanted is None:
            raise Refused(f"object '{message.id}': primitives[{index}].type {primitive.type} is unknown")
        if len(primitive.dimensions) != wanted:
            raise Refused(f"object '{message.id}': primitives[{index}].dimensions has {len(primitive.dimensions)} numbers, not "
                          f"{wanted}")
    for index, mesh in enumerate(message.meshes):
        if not mesh.triangles or not mesh.vertices:
            raise Refused(f"object '{message.id}': meshes[{index}] has {len(mesh.triangles)} triangles and "
                          f"{len(mesh.vertices)} vertices")


def has_pose(message):
    """Returns whether the definition of CollisionObject has the field `pose`, which came with Noetic."""
    return hasattr(message, "pose")


def pose_of(message):
    return message.pose if has_pose(message) else Pose()


def is_empty(pose):
    """Returns whether a pose was not filled in: its position is 0, and its quaternion is the identity or all zeros."""
    p, q = pose.position, pose.orientation
    return (p.x, p.y, p.z, q.x, q.y, q.z) == (0.0,) * 6 and q.w in (0.0, 1.0)


def shapes_of(change):
    """The fields of a change for its shapes, with a pose for each shape."""
    fields = {}
    for kind, poses in KINDS:
        fields[kind] = list(getattr(change, kind))
        fields[poses] = list(getattr(change, poses)) or [Pose() for _ in fields[kind]]
    return fields


def counts_of(message):
    return tuple(len(getattr(message, kind)) for kind, _ in KINDS)


def added(a, b):
    return tuple(x + y for x, y in zip(a, b))


def listed(counts, column):
    return ", ".join(f"{count} {names[column]}" for count, names in zip(counts, KINDS))


def rules_of(matrix):
    """Makes [PairRule] with the same meaning as an AllowedCollisionMatrix. Raises Refused.

    A later rule replaces an earlier one, and a pair without a rule is checked. Defaults that forbid come after those
    that allow, because both names of a pair must allow it if both have a default. Entries come last, without those that
    agree with the defaults.
    """
    check_matrix(matrix)
    defaults = dict(zip(matrix.default_entry_names, map(bool, matrix.default_entry_values)))
    allowing = [name for name, allowed in defaults.items() if allowed]
    forbidding = [name for name, allowed in defaults.items() if not allowed] if allowing else []
    rules = [PairRule(a=name, b="*", allowed=True) for name in allowing]
    rules += [PairRule(a=name, b="*", allowed=False) for name in forbidding]
    rows = [row.enabled for row in matrix.entry_values]
    for i, a in enumerate(matrix.entry_names):
        for j, b in enumerate(matrix.entry_names[:i]):
            allowed = bool(rows[i][j] and rows[j][i])
            ours = [defaults[name] for name in (a, b) if name in defaults]
            if allowed != (bool(ours) and all(ours)):
                rules.append(PairRule(a=b, b=a, allowed=allowed))
    return rules


def check_matrix(matrix):
    size = len(matrix.entry_names)
    where = "allowed_collision_matrix:"
    if len(matrix.entry_values) != size:
        raise Refused(f"{where} entry_values has {len(matrix.entry_values)} rows for {size} entry_names")
    for name, row in zip(matrix.entry_names, matrix.entry_values):
        if len(row.enabled) != size:
            raise Refused(f"{where} the row of '{name}' in entry_values has {len(row.enabled)} entries for {size} names")
    if len(matrix.default_entry_names) != len(matrix.default_entry_values):
        raise Refused(f"{where} default_entry_values has {len(matrix.default_entry_values)} entries for "
                      f"{len(matrix.default_entry_names)} names")
    for names in (matrix.entry_names, matrix.default_entry_names):
        if len(set(names)) != len(names) or not all(names) or "*" in names:
            raise Refused(f"{where} a name is empty, \"*\", or there twice")


# topic: (type of its messages, method that reads them)
TOPICS = {
    "collision_object": ("moveit_msgs/CollisionObject", MessageReader.collision_object),
    "attached_collision_object": ("moveit_msgs/AttachedCollisionObject", MessageReader.attached_object),
    "planning_scene": ("moveit_msgs/PlanningScene", MessageReader.planning_scene),
    "planning_scene_world": ("moveit_msgs/PlanningSceneWorld", MessageReader.replace_world),
    "monitored_planning_scene": ("moveit_msgs/PlanningScene", MessageReader.monitored_scene),
}
