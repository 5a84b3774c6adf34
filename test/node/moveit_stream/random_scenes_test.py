#!/usr/bin/env python3
"""1000 random streams of MoveIt's messages: our changes, applied to a dictionary, give what a second, plain implementation of
MoveIt's rules gives, after each message: the same objects, holders, touch links, places of all shapes, and allowed pairs.

Places are exact: rotations are half turns about the axes, translations are small integers. Frames of tf, links too, are
elsewhere at each message: what is placed by tf at another moment, or rests in another frame, stands somewhere else.
"""

import collections
import copy
import itertools
import pathlib
import random
import sys
import unittest

import moveit_definitions
import rosunit
from proximity_server.msg import ObjectChange

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "src/node/moveit_stream"))
from moveit_scene import TOPICS, MoveItScene, Refused  # noqa: E402

STREAMS, MESSAGES = 1000, 12
IDS, LINKS, FRAMES = ("a", "b", "c"), ("left", "right"), ("", "odom", "camera", "/camera", "left", "right")
NAMES = IDS + LINKS + ("head", "never heard of")
ADD, REMOVE, APPEND, MOVE = range(4)
CLASSES = {version: moveit_definitions.classes_of(version) for version in moveit_definitions.VERSIONS}
PLANNING_FRAME = "odom"
KINDS = (("primitives", "primitive_poses"), ("meshes", "mesh_poses"), ("planes", "plane_poses"))

# --- Places: (signs, translation) maps x to signs * x + translation. The signs are the diagonal of a half turn.

# {x, y, z of the quaternion: signs}
HALF_TURNS = {(0, 0, 0): (1, 1, 1), (1, 0, 0): (1, -1, -1), (0, 1, 0): (-1, 1, -1), (0, 0, 1): (-1, -1, 1)}
IDENTITY = ((1, 1, 1), (0, 0, 0))


def times(a, b):
    return (tuple(i * j for i, j in zip(a[0], b[0])), tuple(t + s * u for t, s, u in zip(a[1], a[0], b[1])))


def inverse(a):
    return (a[0], tuple(-s * t for s, t in zip(*a)))


def place_of(pose):
    p, q = pose.position, pose.orientation
    return (HALF_TURNS[q.x, q.y, q.z], (p.x, p.y, p.z))


class Tf:
    """Where frames are, relative to the planning frame, at the n-th message."""

    def __init__(self, seed, message):
        self.seed, self.message = seed, message

    def __call__(self, frame):
        assert not frame.startswith("/"), frame
        if frame in ("", PLANNING_FRAME):
            return IDENTITY
        dice = random.Random(f"{self.seed} {self.message} {frame}")
        return (dice.choice(list(HALF_TURNS.values())), tuple(dice.randint(-9, 9) for _ in range(3)))


# A shape is a label; an object is its holder ("" or a link), its place in the holder, and its shapes with their places in it.


class Body:
    def __init__(self, holder, place, shapes, touch=()):
        self.holder, self.place, self.shapes, self.touch = holder, place, shapes, set(touch)

    def told(self):
        return self.holder, frozenset(self.touch), frozenset(
            (label, times(self.place, place)) for _, label, place in self.shapes)


# --- MoveIt's rules, plainly. A shape is [kind, label, place in the object].


class NoEffect(Exception):
    """The whole message is left out."""


class PlainMoveIt:
    def __init__(self):
        self.world, self.attached, self.matrix = {}, {}, ({}, {})

    def body(self, message, tf, holder):
        """The object of a CollisionObject in the world (holder ""), or held by a link."""
        shapes = []
        for kind, poses in KINDS:
            given = [place_of(pose) for pose in getattr(message, poses)]
            given += [IDENTITY] * (len(getattr(message, kind)) - len(given))
            shapes += [[kind, label_of(shape), place] for shape, place in zip(getattr(message, kind), given)]
        place = place_of(message.pose) if hasattr(message, "pose") else IDENTITY
        if hasattr(message, "pose") and place == IDENTITY and len(shapes) == 1:
            place, shapes[0][2] = shapes[0][2], IDENTITY
        header = tf(message.header.frame_id.lstrip("/"))
        return Body(holder, times(inverse(tf(holder)), times(header, place)), shapes)

    def collision_object(self, message, tf):
        key = message.id
        if message.operation == ADD or message.operation == APPEND and key not in self.world:
            self.world[key] = self.body(message, tf, "")
        elif message.operation == APPEND:
            self.append(self.world[key], self.body(message, tf, ""))
        elif message.operation == REMOVE:
            for each in [key] if key else list(self.world):
                self.world.pop(each, None)
        elif key in self.world:
            self.move(self.world[key], message, tf)

    @staticmethod
    def append(body, more):
        to_body = times(inverse(body.place), more.place)
        body.shapes += [[kind, label, times(to_body, place)] for kind, label, place in more.shapes]

    @staticmethod
    def move(body, message, tf):
        new = {kind: getattr(message, poses) for kind, poses in KINDS}
        counts = collections.Counter(kind for kind, _, _ in body.shapes)
        fits = all(len(poses) == counts[kind] for kind, poses in new.items())
        if not fits and (any(new.values()) or not hasattr(message, "pose")):
            raise NoEffect
        header = tf(message.header.frame_id.lstrip("/"))
        body.place = times(header, place_of(message.pose) if hasattr(message, "pose") else IDENTITY)
        if fits:
            poses = {kind: iter(given) for kind, given in new.items()}
            for shape in body.shapes:
                shape[2] = place_of(next(poses[shape[0]]))

    def attached_object(self, message, tf):
        key, link = message.object.id, message.link_name
        empty = not (message.object.primitives or message.object.meshes or message.object.planes)
        if message.object.operation == ADD and empty:
            if key in self.world:
                body = self.world.pop(key)
                self.attached[key] = Body(link, times(inverse(tf(link)), body.place), body.shapes, message.touch_links)
        elif message.object.operation == APPEND and key in self.attached:
            if self.attached[key].holder != link:
                raise NoEffect
            self.world.pop(key, None)
            self.append(self.attached[key], self.body(message.object, tf, link))
            self.attached[key].touch |= set(message.touch_links)
        elif message.object.operation in (ADD, APPEND):
            self.world.pop(key, None)
            self.attached[key] = self.body(message.object, tf, link)
            self.attached[key].touch = set(message.touch_links)
        elif message.object.operation == REMOVE:
            held = {each: body for each, body in self.attached.items()
                    if (each == key or not key) and (not link or body.holder == link)}
            for each, body in held.items():
                del self.attached[each]
                self.world.setdefault(each, Body("", times(tf(body.holder), body.place), body.shapes))

    def planning_scene(self, message, tf):
        state, matrix = message.robot_state, message.allowed_collision_matrix
        if not message.is_diff or state.joint_state.name or state.attached_collision_objects:
            if not state.is_diff and (state.joint_state.name or not message.is_diff):
                self.attached = {}
            for each in state.attached_collision_objects:
                if state.is_diff or each.object.operation == ADD:
                    self.attached_object(each, tf)
        if not message.is_diff or matrix.entry_names or matrix.default_entry_names:
            self.matrix = ({(a, b): value for a, row in zip(matrix.entry_names, matrix.entry_values)
                            for b, value in zip(matrix.entry_names, row.enabled) if a != b},
                           dict(zip(matrix.default_entry_names, matrix.default_entry_values)))
        if not message.is_diff:
            self.world = {}
        for each in message.world.collision_objects:
            self.collision_object(each, tf)

    def planning_scene_world(self, message, tf):
        self.world = {}
        for each in message.collision_objects:
            self.collision_object(each, tf)

    def read(self, topic, message, tf):
        """The scene after a message."""
        after = copy.deepcopy(self)
        read = {"collision_object": after.collision_object, "attached_collision_object": after.attached_object,
                "planning_scene_world": after.planning_scene_world}.get(topic, after.planning_scene)
        try:
            read(message, tf)
        except NoEffect:
            return self
        return after

    def allows(self, a, b):
        entries, defaults = self.matrix
        if (a, b) in entries:
            return entries[a, b]
        known = [defaults[name] for name in (a, b) if name in defaults]
        return bool(known) and all(known)

    def told(self):
        return {(key, bool(body.holder)): body.told() for key, body in (*self.world.items(), *self.attached.items())}


# --- What the node does with the changes, plainly, as ObjectChange.msg says.


class PlainNode:
    def __init__(self):
        self.objects, self.rules = {}, []

    def apply(self, changes, tf):
        for change in changes.changes:
            self.change(change, tf)
        if changes.set_rules:
            self.rules = changes.rules

    def change(self, change, tf):
        placed = times(tf(change.header.frame_id), place_of(change.pose))
        body = self.objects.get(change.id)
        assert not change.frame or change.frame == PLANNING_FRAME
        if change.operation == ObjectChange.REPLACE:
            holder = change.link
            self.objects[change.id] = Body(holder, times(inverse(tf(holder)), placed), self.shapes(change), change.touch_links)
        elif change.operation == ObjectChange.APPEND:
            to_body = times(inverse(times(tf(body.holder), body.place)), placed)
            body.shapes += [[kind, label, times(to_body, place)] for kind, label, place in self.shapes(change)]
            body.touch |= set(change.touch_links)
        elif change.operation == ObjectChange.MOVE:
            assert not body.holder
            body.place = placed
            for kind, field in KINDS:
                of_kind, poses = [shape for shape in body.shapes if shape[0] == kind], getattr(change, field)
                assert len(poses) in (0, len(of_kind))
                for shape, pose in zip(of_kind, poses):
                    shape[2] = place_of(pose)
        elif change.operation == ObjectChange.ATTACH:
            assert change.keep_pose and change.link
            body.place = times(inverse(tf(change.link)), times(tf(body.holder), body.place))
            body.holder, body.touch = change.link, set(change.touch_links)
        elif change.operation == ObjectChange.DETACH:
            assert body.holder
            body.place = times(tf(body.holder), body.place)
            body.holder, body.touch = "", set()
        elif change.operation == ObjectChange.REMOVE:
            self.objects.pop(change.id, None)

    @staticmethod
    def shapes(change):
        found = []
        for kind, field in KINDS:
            shapes, poses = getattr(change, kind), getattr(change, field)
            assert len(poses) in (0, len(shapes))
            places = [place_of(pose) for pose in poses] or [IDENTITY] * len(shapes)
            found += [[kind, label_of(shape), place] for shape, place in zip(shapes, places)]
        assert found
        return found

    def allows(self, a, b):
        def names(rule, x, y):
            return rule.a in (x, "*") and rule.b in (y, "*")

        matching = [rule.allowed for rule in self.rules if names(rule, a, b) or names(rule, b, a)]
        return matching[-1] if matching else False

    def told(self):
        return {(key.replace(" (world)", ""), bool(body.holder)): body.told() for key, body in self.objects.items()}


def label_of(shape):
    """The number that the messages below put into each shape."""
    if hasattr(shape, "vertices"):
        return shape.vertices[0].x
    return shape.dimensions[0] if hasattr(shape, "dimensions") else shape.coef[3]


# --- Random messages.


class Dice:
    """Messages of one version, at random; each shape has a label of its own."""

    def __init__(self, seed, labels):
        self.random, self.labels = random.Random(seed), labels
        self.classes = CLASSES[self.random.choice(moveit_definitions.VERSIONS)]
        self.has_pose = "pose" in self.classes["CollisionObject"].__slots__

    def maybe(self, probability=0.5):
        return self.random.random() < probability

    def pose(self):
        result = self.classes["Pose"]()
        if self.maybe(0.8):
            turn = self.random.choice(list(HALF_TURNS))
            result.orientation.x, result.orientation.y, result.orientation.z = turn
            result.orientation.w = 0.0 if any(turn) else self.random.choice([0.0, 1.0])
            result.position.x, result.position.y, result.position.z = (self.random.randint(-3, 3) for _ in range(3))
        return result

    def shape(self, kind):
        label = float(next(self.labels))
        if kind == "primitives":
            return self.classes["SolidPrimitive"](type=2, dimensions=[label])
        if kind == "planes":
            return self.classes["Plane"](coef=[0.0, 0.0, 1.0, label])
        corner, triangle = self.classes["Point"](label, 0, 0), self.classes["MeshTriangle"]([0, 0, 0])
        return self.classes["Mesh"](triangles=[triangle], vertices=[corner])

    def collision_object(self, operations=(ADD, ADD, ADD, REMOVE, APPEND, MOVE, MOVE), ids=IDS):
        operation = self.random.choice(operations)
        key = "" if operation == REMOVE and self.maybe(0.2) else self.random.choice(ids)
        result = self.classes["CollisionObject"](id=key, operation=operation)
        result.header.frame_id = self.random.choice(FRAMES)
        if self.has_pose:
            result.pose = self.pose()
        if operation in (ADD, APPEND):
            for kind, poses in self.random.choices(KINDS, k=self.random.randint(1, 3)):
                getattr(result, kind).append(self.shape(kind))
                getattr(result, poses).append(self.pose())
            if self.has_pose and self.maybe(0.2):
                result.primitive_poses, result.mesh_poses, result.plane_poses = [], [], []
        return result

    def fit(self, message, body):
        """Gives a MOVE as many poses as the object in MoveIt's world has shapes, mostly."""
        if message.operation == MOVE and body and self.maybe(0.9) and not (self.has_pose and self.maybe()):
            for kind, poses in KINDS:
                setattr(message, poses, [self.pose() for shape in body.shapes if shape[0] == kind])

    def attached_object(self):
        inner = self.collision_object(operations=(ADD, ADD, REMOVE, APPEND))
        if inner.operation == ADD and self.maybe():
            for field in ("primitives", "primitive_poses", "meshes", "mesh_poses", "planes", "plane_poses"):
                setattr(inner, field, [])
        result = self.classes["AttachedCollisionObject"](object=inner, link_name=self.random.choice(LINKS))
        if inner.operation == REMOVE and self.maybe():
            result.link_name = ""
        result.touch_links = self.random.sample(LINKS + ("head",), k=self.random.randint(0, 2))
        return result

    def matrix(self):
        names = self.random.sample(NAMES[:-1], k=self.random.randint(0, len(NAMES) - 1))
        result = self.classes["AllowedCollisionMatrix"](entry_names=names)
        entries = {frozenset(pair): self.maybe() for pair in itertools.combinations_with_replacement(names, 2)}
        rows = [[entries[frozenset((a, b))] for b in names] for a in names]
        result.entry_values = [self.classes["AllowedCollisionEntry"](row) for row in rows]
        result.default_entry_names = self.random.sample(NAMES[:-1], k=self.random.randint(0, 3))
        result.default_entry_values = [self.maybe(0.6) for _ in result.default_entry_names]
        return result

    def planning_scene(self):
        result = self.classes["PlanningScene"](is_diff=self.maybe(0.7))
        result.robot_state.is_diff = self.maybe()
        if self.maybe():
            result.robot_state.joint_state.name = ["elbow"]
        result.robot_state.attached_collision_objects = [self.attached_object() for _ in range(self.random.randint(0, 2))]
        result.world.collision_objects = [self.collision_object() for _ in range(self.random.randint(0, 3))]
        if self.maybe(0.4):
            result.allowed_collision_matrix = self.matrix()
        return result

    def message(self, plain):
        """(topic, message)."""
        topic = self.random.choice(["collision_object"] * 4 + ["attached_collision_object"] * 4 +
                                   ["planning_scene", "monitored_planning_scene", "planning_scene_world"])
        if topic == "collision_object":
            message = self.collision_object()
            self.fit(message, plain.world.get(message.id))
            return topic, message
        if topic == "attached_collision_object":
            return topic, self.attached_object()
        scene = self.planning_scene()
        return topic, scene.world if topic == "planning_scene_world" else scene


class RandomScenes(unittest.TestCase):
    def test_our_changes_give_what_the_rules_of_moveit_give(self):
        seen = collections.Counter()
        for seed in range(STREAMS):
            labels = itertools.count(1)
            plain, ours, node = PlainMoveIt(), MoveItScene(PLANNING_FRAME), PlainNode()
            for number in range(MESSAGES):
                tf = Tf(seed, number)
                topic, message = Dice(f"{seed} {number}", labels).message(plain)
                after = plain.read(topic, message, tf)
                try:
                    translation = ours.translate(message, TOPICS[topic][1])
                except Refused:
                    seen["refused"] += 1
                    translation = None
                if translation:
                    node.apply(translation.changes, tf)
                    ours = translation.scene
                    seen.update(change.operation for change in translation.changes.changes)
                seen["refused by the plain rules"] += after is plain
                plain = after
                where = f"stream {seed}, message {number} on {topic}: {message}"
                self.assertEqual(plain.told(), node.told(), where)
                for a, b in itertools.combinations(NAMES, 2):
                    self.assertEqual(plain.allows(a, b), node.allows(a, b), f"{a} and {b}: {where}")
                    seen["allowed"] += plain.allows(a, b)
                seen["twice"] += len(plain.world.keys() & plain.attached.keys()) > 0
                seen["held"] += len(plain.attached) > 0
        # Each rule was met often enough.
        for what in (ObjectChange.REPLACE, ObjectChange.APPEND, ObjectChange.MOVE, ObjectChange.ATTACH, ObjectChange.DETACH,
                     ObjectChange.REMOVE, "twice", "held", "allowed"):
            self.assertGreater(seen[what], 300, (what, seen))
        self.assertEqual(seen["refused"], seen["refused by the plain rules"])
        self.assertLess(seen["refused"], STREAMS * MESSAGES / 10)


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "moveit_random_scenes_test", __name__)
