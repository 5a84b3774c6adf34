#!/usr/bin/env python3
"""MoveIt's messages as changes of our objects: each rule by itself, without a ROS master."""

import pathlib
import sys
import unittest

import moveit_definitions
import rosunit
from geometry_msgs.msg import Pose
from moveit_definitions import VERSIONS
from proximity_server.msg import ObjectChange

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "src/node/moveit_stream"))
from moveit_scene import TOPICS, MoveItScene, Refused  # noqa: E402

CLASSES = {version: moveit_definitions.classes_of(version) for version in VERSIONS}
OBJECT, ATTACHED, SCENE = "collision_object", "attached_collision_object", "planning_scene"  # topics
WORLD, MONITORED = "planning_scene_world", "monitored_planning_scene"
OPERATIONS = {getattr(ObjectChange, name): name for name in
              ("ADD", "REPLACE", "APPEND", "MOVE", "ATTACH", "DETACH", "REMOVE")}


class Words:
    """The messages of one version in few words."""

    def __init__(self, version):
        self.classes = CLASSES[version]

    def pose(self, x=0.0, w=1.0):
        result = self.classes["Pose"]()
        result.position.x, result.orientation.w = x, w
        return result

    def box(self, side=1.0):
        return self.classes["SolidPrimitive"](type=1, dimensions=[side] * 3)

    def mesh(self):
        result = self.classes["Mesh"](triangles=[self.classes["MeshTriangle"]([0, 1, 2])])
        result.vertices = [self.classes["Point"](*corner) for corner in ((0, 0, 0), (1, 0, 0), (0, 1, 0))]
        return result

    def object(self, key, operation, frame="", at=None, **fields):
        """at: the poses of one box for each."""
        result = self.classes["CollisionObject"](id=key, operation=operation, **fields)
        result.header.frame_id = frame
        for x in at or []:
            result.primitives.append(self.box())
            result.primitive_poses.append(self.pose(x))
        return result

    def add(self, key, x=0.0, **fields):
        return self.object(key, self.constant("ADD"), at=[x], **fields)

    def constant(self, name):
        return getattr(self.classes["CollisionObject"], name)

    def attached(self, key, operation, link="hand", touch_links=(), **fields):
        return self.classes["AttachedCollisionObject"](
            link_name=link, touch_links=list(touch_links), object=self.object(key, self.constant(operation), **fields))

    def scene(self, is_diff, *objects, attached=(), joints=(), state_is_diff=False):
        result = self.classes["PlanningScene"](is_diff=is_diff)
        result.world.collision_objects = list(objects)
        result.robot_state.attached_collision_objects = list(attached)
        result.robot_state.joint_state.name = list(joints)
        result.robot_state.is_diff = state_is_diff
        return result

    def matrix(self, names, rows, defaults=()):
        result = self.classes["AllowedCollisionMatrix"](entry_names=list(names))
        result.entry_values = [self.classes["AllowedCollisionEntry"](enabled=list(row)) for row in rows]
        result.default_entry_names = [name for name, _ in defaults]
        result.default_entry_values = [allowed for _, allowed in defaults]
        return result


def in_words(change):
    """As "REPLACE box: hand(finger)": operation, id, and what holds it."""
    holder = f": {change.link}({','.join(change.touch_links)})" if change.link else ""
    return f"{OPERATIONS[change.operation]} {change.id}{holder}"


class Case(unittest.TestCase):
    def setUp(self):
        self.scene = MoveItScene()
        self.warnings = []

    def each_version(self):
        for version in VERSIONS:
            self.setUp()
            yield Words(version)

    def read(self, topic, message):
        """The changes of one message; the scene goes on."""
        translation = self.scene.translate(message, TOPICS[topic][1])
        self.scene, self.warnings = translation.scene, translation.warnings
        return translation.changes

    def changes(self, topic, message):
        return self.read(topic, message).changes

    def words(self, topic, message):
        return [in_words(change) for change in self.changes(topic, message)]

    def expect_refused(self, topic, message, *words):
        before = dict(self.scene.world), dict(self.scene.attached)
        with self.assertRaises(Refused) as refusal:
            self.scene.translate(message, TOPICS[topic][1])
        for each in words:
            self.assertIn(each, str(refusal.exception))
        self.assertEqual(before, (self.scene.world, self.scene.attached))


class WorldObjects(Case):
    def test_add_replaces_an_object_of_the_same_id(self):
        for words in self.each_version():
            self.assertEqual(["REPLACE box"], self.words(OBJECT, words.add("box")))
            self.assertEqual(["REPLACE box"], self.words(OBJECT, words.add("box")))

    def test_append_to_nothing_adds(self):
        for words in self.each_version():
            self.assertEqual(["REPLACE box"], self.words(OBJECT, words.object("box", words.constant("APPEND"), at=[1])))
            self.assertEqual(["APPEND box"], self.words(OBJECT, words.object("box", words.constant("APPEND"), at=[2, 3])))

    def test_shapes_are_in_the_frame_of_the_header_where_the_object_has_no_pose(self):
        words = Words("melodic")
        change, = self.changes(OBJECT, words.object("box", 0, frame="/table", at=[1, 2]))
        self.assertEqual(("table", Pose()), (change.header.frame_id, change.pose))
        self.assertEqual([1, 2], [pose.position.x for pose in change.primitive_poses])

    def test_shapes_are_in_the_frame_of_the_object_where_it_has_a_pose(self):
        words = Words("noetic")
        change, = self.changes(OBJECT, words.object("box", 0, frame="table", at=[1, 2], pose=words.pose(5)))
        self.assertEqual(("table", 5), (change.header.frame_id, change.pose.position.x))
        self.assertEqual([1, 2], [pose.position.x for pose in change.primitive_poses])

    def test_a_single_shape_without_a_pose_of_the_object_gives_it_its_own(self):
        words = Words("noetic")
        for empty in (words.pose(w=0.0), words.pose(w=1.0)):
            change, = self.changes(OBJECT, words.object("box", 0, at=[1], pose=empty))
            self.assertEqual((1, []), (change.pose.position.x, change.primitive_poses))

    def test_poses_of_shapes_may_be_left_out_where_the_object_has_a_pose(self):
        noetic, melodic = (words.object("box", 0, primitives=[words.box()]) for words in (Words("noetic"), Words("melodic")))
        self.assertEqual(["REPLACE box"], self.words(OBJECT, noetic))
        self.expect_refused(OBJECT, melodic, "'box'", "primitive_poses has 0 poses for 1 primitives")

    def test_an_object_rests_in_the_planning_frame_whatever_the_frame_of_its_header(self):
        for words in self.each_version():
            self.scene = MoveItScene(planning_frame="odom")
            in_camera, = self.changes(OBJECT, words.add("a", frame="camera"))
            self.assertEqual(("camera", "odom"), (in_camera.header.frame_id, in_camera.frame))
            unnamed, = self.changes(OBJECT, words.add("b"))
            self.assertEqual(("odom", "odom"), (unnamed.header.frame_id, unnamed.frame))

    def test_move_without_a_pose_of_the_object_gives_every_shape_a_pose(self):
        words = Words("melodic")
        self.changes(OBJECT, words.object("box", 0, at=[1, 2]))
        move = words.object("box", words.constant("MOVE"), frame="table", primitive_poses=[words.pose(3), words.pose(4)])
        change, = self.changes(OBJECT, move)
        self.assertEqual((ObjectChange.MOVE, "table", 0.0), (change.operation, change.header.frame_id, change.pose.position.x))
        self.assertEqual([3, 4], [pose.position.x for pose in change.primitive_poses])
        self.expect_refused(OBJECT, words.object("box", words.constant("MOVE"), primitive_poses=[words.pose(3)]),
                            "'box'", "MOVE has 1 primitive_poses")
        self.expect_refused(OBJECT, words.object("box", words.constant("MOVE")), "MOVE has 0 primitive_poses")

    def test_move_with_a_pose_of_the_object_may_leave_the_shapes_where_they_are_in_it(self):
        words = Words("noetic")
        self.changes(OBJECT, words.object("box", 0, at=[1, 2]))
        change, = self.changes(OBJECT, words.object("box", words.constant("MOVE"), pose=words.pose(9)))
        self.assertEqual((9, []), (change.pose.position.x, change.primitive_poses))
        self.expect_refused(OBJECT, words.object("box", words.constant("MOVE"), primitive_poses=[words.pose(3)]),
                            "'box'", "MOVE has 1 primitive_poses")

    def test_move_of_what_is_not_there_is_told_and_has_no_effect(self):
        for words in self.each_version():
            self.assertEqual([], self.words(OBJECT, words.object("ghost", words.constant("MOVE"))))
            self.assertIn("'ghost'", self.warnings[0])

    def test_remove_takes_one_or_all_of_the_world_and_none_that_is_attached(self):
        for words in self.each_version():
            for key in "abc":
                self.changes(OBJECT, words.add(key))
            self.changes(ATTACHED, words.attached("c", "ADD"))
            remove = words.constant("REMOVE")
            self.assertEqual(["REMOVE a"], self.words(OBJECT, words.object("a", remove)))
            self.changes(OBJECT, words.add("d"))
            self.assertEqual(["REMOVE b", "REMOVE d"], self.words(OBJECT, words.object("", remove)))
            self.assertEqual([], self.words(OBJECT, words.object("c", remove)))
            self.assertEqual([], self.words(OBJECT, words.object("", remove)))

    def test_what_is_not_known_here_is_removed_all_the_same(self):
        # It may be there from before this process was started.
        for words in self.each_version():
            self.assertEqual(["REMOVE old"], self.words(OBJECT, words.object("old", words.constant("REMOVE"))))


class MalformedObjects(Case):
    def test_each_is_refused_with_its_id_and_field(self):
        for words in self.each_version():
            box, pose = words.box, words.pose
            solid = words.classes["SolidPrimitive"]
            for fields, expected in (
                    (dict(primitives=[box(), box()], primitive_poses=[pose()]), "primitive_poses has 1 poses for 2 primitives"),
                    (dict(primitives=[box()], primitive_poses=[pose(), pose()]), "primitive_poses has 2 poses for 1 primitives"),
                    (dict(primitives=[solid(type=0)], primitive_poses=[pose()]), "primitives[0].type 0 is unknown"),
                    (dict(primitives=[box(), solid(type=5)], primitive_poses=[pose()] * 2), "primitives[1].type 5 is unknown"),
                    (dict(primitives=[solid(type=3, dimensions=[1.0])], primitive_poses=[pose()]),
                     "primitives[0].dimensions has 1 numbers, not 2"),
                    (dict(meshes=[words.classes["Mesh"]()], mesh_poses=[pose()]), "meshes[0] has 0 triangles and 0 vertices"),
                    (dict(planes=[words.classes["Plane"]()], plane_poses=[pose()] * 3), "plane_poses has 3 poses for 1 planes"),
                    (dict(), "no shapes")):
                self.expect_refused(OBJECT, words.object("bad", 0, **fields), "'bad'", expected)

    def test_ids_that_are_none_are_refused(self):
        for words in self.each_version():
            for key in ("", "*", "<octomap>"):
                self.expect_refused(OBJECT, words.add(key), f"'{key}'", "id")
            self.expect_refused(OBJECT, words.object("box", 7, at=[1]), "'box'", "operation 7")
            self.expect_refused(ATTACHED, words.attached("box", "ADD", link="", at=[1]), "'box'", "link_name")

    def test_a_frame_that_is_an_object_is_refused(self):
        for words in self.each_version():
            self.changes(OBJECT, words.add("mug"))
            for frame in ("mug", "/mug", "mug/handle"):
                self.expect_refused(OBJECT, words.add("spoon", frame=frame), "'spoon'", "header.frame_id", "mug")

    def test_one_malformed_object_leaves_out_the_whole_scene(self):
        for words in self.each_version():
            self.changes(OBJECT, words.add("there"))
            scene = words.scene(False, words.add("good"), words.object("bad", 0))
            self.expect_refused(SCENE, scene, "'bad'")

    def test_a_message_of_another_kind_is_refused_with_the_field_that_it_lacks(self):
        for words in self.each_version():
            self.expect_refused(SCENE, words.add("box"), "field is missing", "allowed_collision_matrix")


class AttachedObjects(Case):
    def test_add_with_shapes_replaces_what_is_attached_and_what_is_in_the_world(self):
        for words in self.each_version():
            self.changes(OBJECT, words.add("bar"))
            message = words.attached("bar", "ADD", touch_links=["finger", "palm"], frame="hand", at=[1])
            self.assertEqual(["REPLACE bar: hand(finger,palm)"], self.words(ATTACHED, message))
            self.assertEqual(["REPLACE bar: hand(finger,palm)"], self.words(ATTACHED, message))
            self.assertEqual([], self.words(OBJECT, words.object("", words.constant("REMOVE"))))

    def test_add_without_shapes_attaches_an_object_of_the_world_where_it_is(self):
        for words in self.each_version():
            self.changes(OBJECT, words.add("bar"))
            change, = self.changes(ATTACHED, words.attached("bar", "ADD", touch_links=["finger"]))
            self.assertEqual("ATTACH bar: hand(finger)", in_words(change))
            self.assertTrue(change.keep_pose)

    def test_add_without_shapes_of_what_is_not_in_the_world_has_no_effect(self):
        for words in self.each_version():
            self.changes(ATTACHED, words.attached("bar", "ADD", at=[1]))
            for key in ("bar", "ghost"):
                self.assertEqual([], self.words(ATTACHED, words.attached(key, "ADD")))
                self.assertIn(f"'{key}'", self.warnings[0])

    def test_remove_detaches_one_into_the_world(self):
        for words in self.each_version():
            self.changes(ATTACHED, words.attached("bar", "ADD", at=[1]))
            self.assertEqual(["DETACH bar"], self.words(ATTACHED, words.attached("bar", "REMOVE", link="")))
            self.assertEqual(["REMOVE bar"], self.words(OBJECT, words.object("bar", words.constant("REMOVE"))))

    def test_remove_without_an_id_detaches_all_of_a_link_or_all(self):
        for words in self.each_version():
            for key, link in (("a", "left"), ("b", "right"), ("c", "left"), ("d", "head")):
                self.changes(ATTACHED, words.attached(key, "ADD", link=link, at=[1]))
            self.assertEqual(["DETACH a", "DETACH c"],
                             self.words(ATTACHED, words.attached("", "REMOVE", link="left")))
            self.assertEqual(["DETACH b", "DETACH d"], self.words(ATTACHED, words.attached("", "REMOVE", link="")))

    def test_remove_from_another_link_has_no_effect(self):
        for words in self.each_version():
            self.changes(ATTACHED, words.attached("bar", "ADD", at=[1]))
            self.assertEqual([], self.words(ATTACHED, words.attached("bar", "REMOVE", link="foot")))
            self.assertIn("'hand' does", self.warnings[0])

    def test_append_adds_shapes_and_touch_links_to_what_the_link_holds(self):
        for words in self.each_version():
            self.assertEqual(["REPLACE bar: hand(a)"], self.words(
                ATTACHED, words.attached("bar", "APPEND", touch_links=["a"], at=[1])))
            change, = self.changes(ATTACHED, words.attached("bar", "APPEND", touch_links=["b"], at=[2]))
            self.assertEqual((ObjectChange.APPEND, ["b"], 1), (change.operation, change.touch_links, len(change.primitives)))
            self.expect_refused(ATTACHED, words.attached("bar", "APPEND", link="foot", at=[2]),
                                "'bar'", "link_name", "'hand' holds it")

    def test_the_world_may_have_an_object_of_the_same_id(self):
        for words in self.each_version():
            self.changes(ATTACHED, words.attached("bar", "ADD", at=[1]))
            self.assertEqual(["REPLACE bar (world)"], self.words(OBJECT, words.add("bar")))
            # MoveIt does not put a detached object into a world that has one of its id.
            self.assertEqual(["REMOVE bar"], self.words(ATTACHED, words.attached("bar", "REMOVE")))
            self.assertEqual(["REMOVE bar (world)"], self.words(OBJECT, words.object("bar", words.constant("REMOVE"))))

    def test_both_objects_of_the_same_id_make_room_for_one_that_is_attached(self):
        for words in self.each_version():
            for with_shapes, expected in (([1], ["REMOVE bar (world)", "REPLACE bar: hand()"]),
                                          ([], ["REMOVE bar", "ATTACH bar (world): hand()"])):
                self.scene = MoveItScene()
                self.changes(ATTACHED, words.attached("bar", "ADD", at=[1]))
                self.changes(OBJECT, words.add("bar"))
                self.assertEqual(expected, self.words(ATTACHED, words.attached("bar", "ADD", at=with_shapes)))


class Scenes(Case):
    def fill(self, words):
        """Objects a and b in the world, c attached."""
        for key in "ab":
            self.changes(OBJECT, words.add(key))
        self.changes(ATTACHED, words.attached("c", "ADD", at=[1]))

    def test_a_scene_that_is_no_diff_replaces_everything(self):
        for words in self.each_version():
            self.fill(words)
            message = words.scene(False, words.add("b"), words.add("d"), attached=[words.attached("e", "ADD", at=[1])])
            changes = self.read(SCENE, message)
            self.assertEqual(["REMOVE c", "REPLACE e: hand()", "REMOVE a", "REMOVE b", "REPLACE b", "REPLACE d"],
                             [in_words(change) for change in changes.changes])
            self.assertEqual((True, []), (changes.set_rules, changes.rules))

    def test_a_diff_leaves_what_it_does_not_name(self):
        for words in self.each_version():
            self.fill(words)
            changes = self.read(SCENE, words.scene(True, words.add("d")))
            self.assertEqual((["REPLACE d"], False), ([in_words(change) for change in changes.changes], changes.set_rules))

    def test_a_diff_of_the_robot_state_leaves_what_is_attached(self):
        for words in self.each_version():
            self.fill(words)
            message = words.scene(True, attached=[words.attached("e", "ADD", at=[1])], joints=["elbow"], state_is_diff=True)
            self.assertEqual(["REPLACE e: hand()"], self.words(SCENE, message))

    def test_a_robot_state_that_is_no_diff_replaces_what_is_attached(self):
        for words in self.each_version():
            self.fill(words)
            message = words.scene(True, attached=[words.attached("e", "ADD", at=[1])], joints=["elbow"])
            self.assertEqual(["REMOVE c", "REPLACE e: hand()"], self.words(SCENE, message))

    def test_a_diff_with_an_empty_robot_state_leaves_what_is_attached(self):
        for words in self.each_version():
            self.fill(words)
            self.assertEqual([], self.words(SCENE, words.scene(True)))

    def test_only_a_diff_of_the_robot_state_detaches(self):
        for words in self.each_version():
            self.fill(words)
            detach = [words.attached("c", "REMOVE", link="")]
            self.assertEqual([], self.words(SCENE, words.scene(True, attached=detach)))
            self.assertIn("robot_state.is_diff", self.warnings[0])
            self.assertEqual(["DETACH c"], self.words(SCENE, words.scene(True, attached=detach, state_is_diff=True)))

    def test_a_detached_object_is_placed_by_the_same_diff(self):
        # As move_group sends it: first the robot state, then the world.
        for words in self.each_version():
            self.fill(words)
            message = words.scene(True, words.add("c"), attached=[words.attached("c", "REMOVE", link="")], state_is_diff=True)
            self.assertEqual(["DETACH c", "REPLACE c"], self.words(MONITORED, message))

    def test_a_world_replaces_the_world_only(self):
        for words in self.each_version():
            self.fill(words)
            world = words.scene(True, words.add("d")).world
            self.assertEqual(["REMOVE a", "REMOVE b", "REPLACE d"], self.words(WORLD, world))
            self.assertEqual(["c"], list(self.scene.attached))

    def test_a_monitored_scene_that_begins_with_a_diff_is_told_once(self):
        for words in self.each_version():
            self.changes(MONITORED, words.scene(True))
            self.assertIn("began with a diff", self.warnings[0])
            self.changes(MONITORED, words.scene(True))
            self.assertEqual([], self.warnings)
            self.setUp()
            for is_diff in (False, True):
                self.changes(MONITORED, words.scene(is_diff))
                self.assertEqual([], self.warnings)

    def test_octomaps_are_refused_with_one_warning(self):
        for words in self.each_version():
            message = words.scene(True, words.add("box"))
            message.world.octomap.octomap.id, message.world.octomap.octomap.data = "OcTree", [1, 2]
            self.assertEqual(["REPLACE box"], self.words(SCENE, message))
            self.assertIn("octomap", self.warnings[0])
            self.changes(SCENE, message)
            self.assertEqual([], self.warnings)

    def test_padding_and_scale_of_links_are_refused_with_the_parameter_to_set(self):
        for words in self.each_version():
            message = words.scene(True)
            message.link_padding = [words.classes["LinkPadding"]("wrist", 0.02), words.classes["LinkPadding"]("hand", 0.0)]
            message.link_scale = [words.classes["LinkScale"]("wrist", 1.0), words.classes["LinkScale"]("hand", 1.1)]
            self.assertEqual([], self.words(SCENE, message))
            padding, scale = self.warnings
            self.assertIn("link_padding: {wrist: 0.02}", padding)
            self.assertIn("hand", scale)
            self.changes(SCENE, message)
            self.assertEqual([], self.warnings)


class LinksOfOneOfSeveralRobots(Case):
    """The node has "left/" in front of the links of MoveIt's robot."""

    def setUp(self):
        super().setUp()
        self.scene = MoveItScene("base")
        self.scene.set_link_names({name: f"left/{name}" for name in ("base", "hand", "finger")})

    def test_hold_and_touch_by_the_name_that_the_node_gives_them(self):
        for words in self.each_version():
            attach = words.attached("bar", "ADD", at=[1], touch_links=["finger", "mat"])
            self.assertEqual(["REPLACE bar: left/hand(left/finger,mat)"], self.words(ATTACHED, attach))
            change, = self.changes(ATTACHED, words.attached("bar", "APPEND", at=[2], touch_links=["finger"]))
            self.assertEqual(["left/finger"], change.touch_links)
            self.assertEqual(["DETACH bar"], self.words(ATTACHED, words.attached("bar", "REMOVE")))
            self.assertEqual(["ATTACH bar: left/hand(left/finger)"],
                             self.words(ATTACHED, words.attached("bar", "ADD", touch_links=["finger"])))
            self.assertEqual(["DETACH bar"], self.words(ATTACHED, words.attached("", "REMOVE")))

    def test_are_frames_by_that_name(self):
        for words in self.each_version():
            for frame, in_node in (("hand", "left/hand"), ("/hand", "left/hand"), ("map", "map"), ("", "left/base")):
                change, = self.changes(OBJECT, words.add("box", frame=frame))
                self.assertEqual((in_node, "left/base"), (change.header.frame_id, change.frame))

    def test_are_in_the_rules_by_that_name(self):
        for words in self.each_version():
            message = words.scene(True)
            message.allowed_collision_matrix = words.matrix(("hand", "shelf"), [[0, 1], [1, 0]], defaults=[("finger", True)])
            rules = [(rule.a, rule.b) for rule in self.read(SCENE, message).rules]
            self.assertEqual([("left/finger", "*"), ("left/hand", "shelf")], rules)


class Rules(Case):
    def rules(self, matrix, words):
        message = words.scene(True)
        message.allowed_collision_matrix = matrix
        changes = self.read(SCENE, message)
        self.assertTrue(changes.set_rules)
        return [(rule.a, rule.b, rule.allowed) for rule in changes.rules]

    def test_entries_allow_pairs(self):
        for words in self.each_version():
            matrix = words.matrix("abc", [[0, 1, 0], [1, 0, 0], [0, 0, 0]])
            self.assertEqual([("a", "b", True)], self.rules(matrix, words))

    def test_an_entry_wins_over_the_defaults(self):
        for words in self.each_version():
            matrix = words.matrix("ab", [[0, 0], [0, 0]], defaults=[("a", True)])
            self.assertEqual([("a", "*", True), ("a", "b", False)], self.rules(matrix, words))

    def test_two_defaults_allow_only_together(self):
        for words in self.each_version():
            matrix = words.matrix("", [], defaults=[("a", True), ("b", False), ("c", True)])
            self.assertEqual([("a", "*", True), ("c", "*", True), ("b", "*", False)], self.rules(matrix, words))

    def test_an_entry_that_is_not_symmetric_allows_nothing(self):
        for words in self.each_version():
            for rows in ([[0, 1], [0, 0]], [[0, 0], [1, 0]]):
                self.assertEqual([], self.rules(words.matrix("ab", rows), words))

    def test_sizes_that_do_not_fit_are_refused(self):
        for words in self.each_version():
            for matrix, expected in ((words.matrix("ab", [[0, 0]]), "1 rows for 2"),
                                     (words.matrix("ab", [[0, 0], [0]]), "row of 'b'"),
                                     (words.matrix(["a", "a"], [[0, 0]] * 2), "twice"), (words.matrix(["*"], [[0]]), "\"*\"")):
                message = words.scene(True)
                message.allowed_collision_matrix = matrix
                self.expect_refused(SCENE, message, "allowed_collision_matrix", expected)
            matrix = words.matrix("", [], defaults=[("a", True)])
            matrix.default_entry_values = []
            message.allowed_collision_matrix = matrix
            self.expect_refused(SCENE, message, "default_entry_values has 0 entries for 1")


class AfterARestart(Case):
    """What is sent again to a node that has lost everything."""

    def again(self):
        changes, lost = self.scene.recreated()
        return [in_words(change) for change in changes.changes], lost

    def test_what_rests_where_its_message_said_is_made_again(self):
        for words in self.each_version():
            self.changes(OBJECT, words.add("box", x=3))
            self.changes(ATTACHED, words.attached("bar", "ADD", touch_links=["finger"], frame="hand", at=[1]))
            self.assertEqual((["REPLACE box", "REPLACE bar: hand(finger)"], []), self.again())

    def test_what_only_tf_knew_at_a_moment_is_named_and_forgotten(self):
        for words in self.each_version():
            self.changes(OBJECT, words.add("seen", frame="camera"))
            self.changes(OBJECT, words.add("held"))
            self.changes(ATTACHED, words.attached("held", "ADD"))
            self.changes(ATTACHED, words.attached("put", "ADD", frame="hand", at=[1]))
            self.changes(ATTACHED, words.attached("put", "REMOVE"))
            again, lost = self.again()
            self.assertEqual(([], ["held", "put", "seen"]), (again, sorted(lost)))
            self.assertEqual(({}, {}), (self.scene.world, self.scene.attached))

    def test_shapes_that_were_appended_and_moved_come_again_with_their_last_poses(self):
        words = Words("melodic")
        self.changes(OBJECT, words.object("box", 0, at=[1]))
        self.changes(OBJECT, words.object("box", words.constant("APPEND"), at=[2]))
        self.changes(OBJECT, words.object("box", words.constant("MOVE"), primitive_poses=[words.pose(5), words.pose(6)]))
        change, = self.scene.recreated()[0].changes
        self.assertEqual((2, [5, 6]), (len(change.primitives), [pose.position.x for pose in change.primitive_poses]))

    def test_shapes_that_were_appended_in_another_frame_cannot_come_again(self):
        for words in self.each_version():
            self.changes(OBJECT, words.object("box", 0, at=[1, 2]))
            self.changes(OBJECT, words.object("box", words.constant("APPEND"), frame="table", at=[2, 3]))
            self.assertEqual(([], ["box"]), self.again())

    def test_the_rules_come_again(self):
        for words in self.each_version():
            message = words.scene(True)
            message.allowed_collision_matrix = words.matrix("ab", [[0, 1], [1, 0]])
            self.changes(SCENE, message)
            changes, _ = self.scene.recreated()
            self.assertEqual((True, 1), (changes.set_rules, len(changes.rules)))
        self.setUp()
        self.assertFalse(self.scene.recreated()[0].set_rules)


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "moveit_translation_test", "__main__")
