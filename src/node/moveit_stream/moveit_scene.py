"""What MoveIt's messages say of objects, as changes for ~apply_objects. Needs no ROS master: messages in, messages out.

1. A MoveItScene is what MoveIt's scene holds after the messages so far: what is in the world, and what is attached to which
   link.
2. A message is read by the rules of its type. Each step of it becomes an ObjectChange, and changes a copy of the scene.
3. The caller has the changes applied and goes on with the new scene; if they are refused, it keeps the old one. After a
   restart of the node, the scene says how to make its objects again.

Source: the comments in moveit_msgs; for what they leave open, how planning_scene of Melodic and Noetic behaves. The messages of
both are read. They differ in the field `pose` of CollisionObject, which came with Noetic:
* Without it, the poses of shapes are in the frame of the header. With it they are relative to `pose`, and may be left out.
* With it, a single shape with an empty `pose` gives the object its own frame, as in Noetic.
* MOVE: without it, every shape has a new pose. With it, the poses of shapes are given only if they change too.

Where:   A world object stays where it is in the planning frame, whatever the frame of its header does later: the node asks tf
         once, for the newest transform. MoveIt does not use stamps either. A leading '/' of a frame is dropped, as in MoveIt.
Pairs:   Where the allowed-collision matrix has an entry for two names, it decides; else their defaults do, both of them if
         both names have one, as AllowedCollisionMatrix.msg says. touch_links allow on top of it. An entry that is not
         symmetric allows nothing.

Deviations from MoveIt:
* A plane is solid below it (a x + b y + c z + d <= 0); in MoveIt it is a surface. So its normal has to point to the free side.
* APPEND places its shapes by its own header and `pose`, as Melodic does and as the comments say. Noetic takes the frame of the
  object, which is the same if `pose` is the object's. An attached object does not move by it.
* In MoveIt the world may have an object with the id of an attached one. Here it is called "<id> (world)".
* Octomaps are not supported. link_padding and link_scale are not taken over: paddings are parameters of the node, and a
  message shall not lower them. A warning says so, and names the parameter.
* A frame that is an object of the scene, or a subframe of one, is refused, because tf does not know it.
* One malformed object leaves out the whole message.
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
    """The message cannot be read: it is left out whole. The words name the object and the field."""


class Entry(collections.namedtuple("Entry", "name link touch_links counts shapes place")):
    """An object in MoveIt's scene.

    name:   its id in the node
    link:   that holds it, "" in the world
    counts: of its shapes, for each of KINDS
    shapes: the fields of an ObjectChange with the shapes and one pose for each; None if not all poses are known in one frame
    place:  the header and pose that say where it is until the next change; None if that depends on tf at a time that is over
    """

    def moved(self, frame, header, pose):
        """With the place that a change gives it; `frame` is the one that it moves with."""
        return self._replace(place=(header, pose) if header.frame_id == frame else None)

    def with_more(self, change):
        """With the shapes of an APPEND."""
        shapes = None
        if self.shapes and self.place == (change.header, change.pose):
            more = shapes_of(change)
            shapes = {field: self.shapes[field] + more[field] for field in more}
        return self._replace(counts=added(self.counts, counts_of(change)), shapes=shapes)

    def again(self, frame):
        """The change that makes it in a node that does not know it, or None."""
        if not self.shapes or not self.place:
            return None
        header, pose = self.place
        return ObjectChange(operation=ObjectChange.REPLACE, id=self.name, link=self.link, touch_links=self.touch_links,
                            frame="" if self.link else frame, header=header, pose=pose, **self.shapes)


# What one message says. changes: ObjectChanges, maybe none. warnings: sentences. scene: MoveIt's scene after it.
Translation = collections.namedtuple("Translation", "changes warnings scene")


class MoveItScene:
    """What MoveIt's scene holds, as far as messages tell of other objects.

    planning_frame: the tf frame in which MoveIt's world rests; "": the reference frame of the node.
    links:          the names in the node of links that MoveIt knows by other names
    """

    def __init__(self, planning_frame=""):
        self.planning_frame = planning_frame
        self.links = {}
        self.world, self.attached = {}, {}  # id: Entry
        self.rules = None  # [PairRule], None: MoveIt did not send a matrix
        self.told = set()  # the warnings that are given once

    def translate(self, message, read):
        """The Translation of a message by one of the readers in TOPICS; this scene stays as it is. Raises Refused."""
        step = Step(self)
        try:
            read(step, message)
        except (AttributeError, TypeError) as error:
            raise Refused(f"a field is missing, or has another type: {error}") from error
        return Translation(step.changes, step.warnings, step.scene)

    def call_links(self, links):
        """From now on, links[name] is the name in the node of MoveIt's link `name`, also of its frame."""
        self.links = links
        self.planning_frame = links.get(self.planning_frame, self.planning_frame)

    def again(self):
        """(ObjectChanges that make all of it in a node without objects, names of those that cannot be placed).

        They are no longer part of this scene.
        """
        changes = ObjectChanges(set_rules=self.rules is not None, rules=self.rules or [])
        lost = []
        for entries in (self.world, self.attached):
            for key, entry in list(entries.items()):
                change = entry.again(self.planning_frame)
                if change:
                    changes.changes.append(change)
                else:
                    lost.append(entries.pop(key).name)
        return changes, lost


class Step:
    """One message in the course of being read."""

    def __init__(self, scene):
        self.scene = copy.copy(scene)
        self.scene.world, self.scene.attached = dict(scene.world), dict(scene.attached)
        self.scene.told = set(scene.told)
        self.changes = ObjectChanges()
        self.warnings = []

    def warn(self, words):
        self.warnings.append(words)

    def warn_once(self, words):
        if words not in self.scene.told:
            self.scene.told.add(words)
            self.warn(words)

    def change(self, operation, name, **fields):
        result = ObjectChange(operation=operation, id=name, **fields)
        self.changes.changes.append(result)
        return result

    def replace(self, name, message, frame="", link="", touch_links=()):
        """Makes an object from the shapes of a CollisionObject. Raises Refused."""
        change = self.change(ObjectChange.REPLACE, name, frame=frame, link=link, touch_links=list(touch_links),
                             **self.placed_shapes(message))
        entry = Entry(name, link, change.touch_links, counts_of(change), shapes_of(change), None)
        return entry.moved(link or frame, change.header, change.pose)

    # --- One object.

    def collision_object(self, message):
        """CollisionObject: an object of the world."""
        check_id(message)
        operations = {ADD: self.add, APPEND: self.append, MOVE: self.move, REMOVE: self.remove}
        if message.operation not in operations:
            raise Refused(f"object '{message.id}': operation {message.operation} is unknown")
        operations[message.operation](message)

    def add(self, message):
        there = self.scene.world.get(message.id)
        name = there.name if there else self.name_in_world(message.id)
        self.scene.world[message.id] = self.replace(name, message, frame=self.scene.planning_frame)

    def name_in_world(self, key):
        attached = self.scene.attached.get(key)
        return f"{key} (world)" if attached and attached.name == key else key

    def append(self, message):
        there = self.scene.world.get(message.id)
        if there is None:
            self.add(message)
            return
        change = self.change(ObjectChange.APPEND, there.name, **self.placed_shapes(message))
        self.scene.world[message.id] = there.with_more(change)

    def move(self, message):
        there = self.scene.world.get(message.id)
        if there is None:
            self.warn(f"object '{message.id}': MOVE of what is not in the world has no effect")
            return
        given = tuple(len(getattr(message, poses)) for _, poses in KINDS)
        if given != there.counts and (any(given) or not has_pose(message)):
            raise Refused(f"object '{message.id}': MOVE has {listed(given, 1)} for {listed(there.counts, 0)}")
        if any(counts_of(message)):
            self.warn(f"object '{message.id}': MOVE does not read the shapes in its message")
        poses = {poses: getattr(message, poses) for _, poses in KINDS if getattr(message, poses)}
        change = self.change(ObjectChange.MOVE, there.name, frame=self.scene.planning_frame, pose=pose_of(message),
                             header=self.header_of(message), **poses)
        shapes = there.shapes and {**there.shapes, **poses}
        self.scene.world[message.id] = there._replace(shapes=shapes).moved(change.frame, change.header, change.pose)

    def remove(self, message):
        """REMOVE: one object of the world, or with id "" all of them; those that are attached stay."""
        if not message.id:
            self.remove_world()
        elif message.id in self.scene.world:
            self.change(ObjectChange.REMOVE, self.scene.world.pop(message.id).name)
        elif message.id not in self.scene.attached:
            # The node may have it from before this process was started.
            self.change(ObjectChange.REMOVE, message.id)

    def remove_world(self):
        for entry in self.scene.world.values():
            self.change(ObjectChange.REMOVE, entry.name)
        self.scene.world.clear()

    # --- One attached object.

    def attached_object(self, message):
        """AttachedCollisionObject: attaches one, or detaches one or many."""
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
        """ADD without geometry: the link holds an object of the world from now on, where it is."""
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
        """ADD, or APPEND to nothing: replaces what is attached, and what is in the world, under this id."""
        key = message.object.id
        entry, in_world = self.scene.attached.get(key), self.scene.world.pop(key, None)
        if entry and in_world:
            self.change(ObjectChange.REMOVE, in_world.name)
        name = entry.name if entry else in_world.name if in_world else key
        self.scene.attached[key] = self.replace(name, message.object, link=self.in_node(message.link_name),
                                                touch_links=self.all_in_node(message.touch_links))

    def detach(self, message):
        """REMOVE: puts one object back into the world, or with id "" all of the link, or with link_name "" too all."""
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
        """PlanningScene: a diff to the scene that is there, or another one."""
        matrix = message.allowed_collision_matrix
        self.robot_state(message)
        if not message.is_diff or matrix.entry_names or matrix.default_entry_names:
            self.set_rules(matrix)
        self.refuse_link_sizes(message)
        if not message.is_diff:
            self.remove_world()
        self.world_objects(message.world)

    def monitored_scene(self, message):
        """PlanningScene, from move_group: first the whole scene, then diffs."""
        missed = "monitored_planning_scene began with a diff: what MoveIt's scene held before is not known here"
        if message.is_diff:
            self.warn_once(missed)
        self.planning_scene(message)
        self.scene.told.add(missed)

    def replace_world(self, message):
        """PlanningSceneWorld: another world; what is attached stays."""
        self.remove_world()
        self.world_objects(message)

    def world_objects(self, world):
        for each in world.collision_objects:
            self.collision_object(each)
        if world.octomap.octomap.data:
            self.warn_once("octomaps are not supported: the octomap in MoveIt's scene is not checked")

    def robot_state(self, message):
        """PlanningScene.robot_state: what is attached, instead of or in addition to what was."""
        state = message.robot_state
        has_joints = state.joint_state.name or state.multi_dof_joint_state.joint_names
        is_diff = getattr(state, "is_diff", message.is_diff)  # Groovy had no such field
        # In a diff, MoveIt does not take a state without joints for a state, though it attaches its objects.
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
        """The name in the node of what MoveIt calls so."""
        return self.scene.links.get(name, name)

    def all_in_node(self, names):
        return [self.in_node(name) for name in names]

    def placed_shapes(self, message):
        """The fields of an ObjectChange for shapes with their poses, and for the pose of their frame. Raises Refused."""
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
    """Whether the definition of CollisionObject has `pose`, as from Noetic on."""
    return hasattr(message, "pose")


def pose_of(message):
    return message.pose if has_pose(message) else Pose()


def is_empty(pose):
    """Whether nothing was filled in: no translation, and the identity, or zeros, as quaternion."""
    p, q = pose.position, pose.orientation
    return (p.x, p.y, p.z, q.x, q.y, q.z) == (0.0,) * 6 and q.w in (0.0, 1.0)


def shapes_of(change):
    """Its shapes with one pose for each."""
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
    """[PairRule] that say of every pair what an AllowedCollisionMatrix says. Raises Refused.

    A later rule wins, and a pair without a rule is checked. Defaults that forbid come after those that allow, because both
    names of a pair must allow it if both have a default. Entries come last; those that equal the defaults are left out.
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


# topic: (the type of its messages, how they are read)
TOPICS = {
    "collision_object": ("moveit_msgs/CollisionObject", Step.collision_object),
    "attached_collision_object": ("moveit_msgs/AttachedCollisionObject", Step.attached_object),
    "planning_scene": ("moveit_msgs/PlanningScene", Step.planning_scene),
    "planning_scene_world": ("moveit_msgs/PlanningSceneWorld", Step.replace_world),
    "monitored_planning_scene": ("moveit_msgs/PlanningScene", Step.monitored_scene),
}
