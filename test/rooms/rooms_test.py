#!/usr/bin/env python3
"""Checks that no include of src/ or include/ runs back up: the order of the rooms is the block ```rooms of src/README.md.

usage: rooms_test.py SOURCE_DIR

A room is a folder below src/ and include/proximity_server/, or a file with its header where no such folder exists. The rules:
* each file belongs to a room of the list, and each room of the list has a file;
* a file includes only files of its own room and of rooms that stand before it, and these exist;
* what UNRELATED lists does not include each other;
* a room has at most MOST_UNITS units, headers with their sources, and these do not include each other in a circle;
* the rooms of scene stand on at most MOST_FLOORS floors: a room stands one above the highest room of scene that it includes;
* a header below src/ is private to its layer, the first folder of its path, and to those that SHARED_WITH names.
Includes with angle brackets are checked where they name a public header. Tests are not checked.

The includes of a file, and of each test, begin with its own header; ours follow, then those of libraries, then the standard's.

A cell of a table of the map has at most LONGEST_CELL characters, one of config/PARAMETERS.md at most two sentences.
"""

import collections
import pathlib
import re
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv[1]).resolve()
PUBLIC = "include/proximity_server"
SUFFIXES = (".h", ".cpp")
MOST_UNITS = 12
MOST_FLOORS = 10
LONGEST_CELL = 200
UNRELATED = (("tools", "node"), ("tools", "demo"), ("python", "tools"), ("python", "node"), ("python", "demo"))  # layers
# Layers whose private headers others may include, and who.
SHARED_WITH = {"system": ("scene", "tools", "python", "node", "demo"), "node": ("demo",)}
# Every other name below "proximity_server/" is a public header; these are generated from msg/, srv/ and config/.
GENERATED = re.compile(r"proximity_server/[A-Z]\w*\.h")


def rooms_of(map_text):
    """The rooms in their order, lowest first."""
    return re.search(r"(?ms)^```rooms\n(.*?)^```", map_text)[1].split()


def name_of(path):
    """The path of a file below its tree, without suffix: what an include of it and its room have in common."""
    for tree in (PUBLIC, "src"):
        if path.startswith(tree + "/"):
            return path[len(tree) + 1:].rpartition(".")[0]
    raise ValueError(path)


def room_of(path, rooms):
    """The room of a file, or None."""
    name = name_of(path)
    return next((room for room in rooms if name == room or name.startswith(room + "/")), None)


def includes(text):
    """What a source includes of this project, or by a relative path."""
    for bracket, name in re.findall(r'(?m)^\s*#\s*include\s*(["<])([^">]+)[">]', text):
        if (bracket == '"' or name.startswith("proximity_server/")) and not GENERATED.fullmatch(name):
            yield name


def file_of(include):
    """The path below the source folder that an include means."""
    return ("include/" if include.startswith("proximity_server/") else "src/") + include


def layer_of(room):
    return room.split("/")[0]


def problem_of(path, room, include, rooms, files):
    """What is wrong with an include of a file in a room; None if nothing is."""
    target = file_of(include)
    if target not in files:
        return f"{target} does not exist"
    included = room_of(target, rooms)
    if included is None:
        return f"{target} belongs to no room"
    if rooms.index(included) > rooms.index(room):
        return f"runs back up from {room} to {included}"
    if any({layer_of(room), layer_of(included)} == set(pair) for pair in UNRELATED):
        return f"{layer_of(room)} ({room}) and {layer_of(included)} ({included}) do not include each other"
    sharers = (layer_of(included), *SHARED_WITH.get(layer_of(included), ()))
    if target.startswith("src/") and layer_of(room) not in sharers:
        return f"is private to {layer_of(included)} ({included}), and {room} is not of it"
    return None


def problems(source):
    """Every break of the rules below a source folder, as one line each."""
    rooms = rooms_of((source / "src/README.md").read_text())
    files = sorted(path.relative_to(source).as_posix() for tree in (PUBLIC, "src")
                   for path in (source / tree).rglob("*") if path.suffix in SUFFIXES)
    for room in rooms:
        if not any(room_of(path, rooms) == room for path in files):
            yield f"the room {room} has no file"
    for path in files:
        room = room_of(path, rooms)
        if room is None:
            yield f"{path} belongs to no room"
            continue
        for include in includes((source / path).read_text()):
            problem = problem_of(path, room, include, rooms, files)
            if problem:
                yield f'{path}: #include "{include}" {problem}'


def circle_from(start, edges):
    """The shortest way along the edges from a unit back to itself, or None."""
    ways = [[start]]
    seen = set()
    for way in ways:
        for unit in sorted(edges.get(way[-1], ())):
            if unit == start:
                return [*way, unit]
            if unit not in seen:
                seen.add(unit)
                ways.append([*way, unit])
    return None


def problems_within_rooms(source):
    """Rooms with too many units, and circles of units in a room, as one line each."""
    rooms = rooms_of((source / "src/README.md").read_text())
    files = [path.relative_to(source).as_posix() for tree in (PUBLIC, "src")
             for path in (source / tree).rglob("*") if path.suffix in SUFFIXES]
    units = collections.defaultdict(set)  # of each room
    edges = collections.defaultdict(set)  # from a unit to others of its room
    for path in files:
        room, unit = room_of(path, rooms), name_of(path)
        units[room].add(unit)
        for include in includes((source / path).read_text()):
            other = file_of(include)
            if other in files and room_of(other, rooms) == room and name_of(other) != unit:
                edges[unit].add(name_of(other))
    for room in rooms:
        if len(units[room]) > MOST_UNITS:
            yield f"{room} has {len(units[room])} units"
        told = set()  # of the units in circles
        for unit in sorted(units[room]):
            circle = circle_from(unit, edges)
            if circle and not told.intersection(circle):
                yield "runs in a circle: " + " -> ".join(circle)
                told.update(circle)


def floors(source):
    """The floor of each room of scene, counted from 1."""
    rooms = rooms_of((source / "src/README.md").read_text())
    below = collections.defaultdict(set)  # the rooms of scene that a room includes
    for tree in (PUBLIC, "src"):
        for path in (source / tree / "scene").rglob("*"):
            if path.suffix in SUFFIXES:
                room = room_of(path.relative_to(source).as_posix(), rooms)
                below[room].update(room_of(file_of(include), rooms) for include in includes(path.read_text()))
    floor = {}
    for room in rooms:  # lowest first
        if layer_of(room) == "scene":
            floor[room] = 1 + max((floor[other] for other in below[room] if other in floor), default=0)
    return floor


def cells(document):
    """The cells of all tables of a document."""
    rows = re.findall(r"(?m)^\| (.*) \|$", (SOURCE / document).read_text())
    return [cell for row in rows for cell in row.split(" | ")]


def rank_of(bracket, name, path):
    """0: a header with the name of the file, 1: another one of this project, 2: of a library or the system, 3: of the standard library."""
    unit = re.sub("_test$", "", pathlib.PurePath(path).stem)
    if path.endswith(".cpp") and pathlib.PurePath(name).name == unit + ".h":
        return 0
    if bracket == '"' or name.startswith("proximity_server/"):
        return 1
    return 3 if re.fullmatch(r"\w+", name) else 2


def problems_of_order(source):
    """Files whose first block of includes is not in the order that the top of this file tells."""
    for tree in ("include", "src", "test"):
        for path in sorted((source / tree).rglob("*")):
            if path.suffix in SUFFIXES:
                block = re.search(r'(?m)(^#include [<"][^>"]+[>"].*\n+)+', path.read_text() + "\n")
                found = re.findall(r'#include ([<"])([^>"]+)', block[0]) if block else []
                ranks = [max(rank_of(bracket, name, path.name), i > 0) for i, (bracket, name) in enumerate(found)]
                if ranks != sorted(ranks):
                    low = next(i for i in range(1, len(ranks)) if ranks[i] < ranks[i - 1])
                    yield f"{path.relative_to(source)}: {found[low][1]} stands too low"


class Rooms(unittest.TestCase):
    def test_cells_of_the_map_are_short(self):
        self.assertEqual([], [cell for cell in cells("src/README.md") if len(cell) > LONGEST_CELL])

    def test_a_parameter_is_explained_in_two_sentences(self):
        self.assertEqual([], [cell for cell in cells("config/PARAMETERS.md") if len(re.findall(r"[.?!](?= |$)", cell)) > 2])

    def test_includes_stand_in_one_order(self):
        self.assertEqual([], list(problems_of_order(SOURCE)))

    def test_rooms_are_small_and_have_no_circles(self):
        self.assertEqual([], list(problems_within_rooms(SOURCE)))

    def test_no_include_of_a_layer_runs_back_up(self):
        self.assertEqual([], list(problems(SOURCE)))

    def test_scene_has_few_floors(self):
        highest = max(floors(SOURCE).items(), key=lambda item: item[1])
        self.assertLessEqual(highest[1], MOST_FLOORS, highest[0])

    def test_the_order_of_the_rooms_names_none_of_them_twice(self):
        rooms = rooms_of((SOURCE / "src/README.md").read_text())
        self.assertEqual(sorted(set(rooms)), sorted(rooms))


MAP = """```rooms
system
narrowphase/shape
scene/mesh
scene/query
tools/clearance
node/system
node/main
demo
```"""
# A source folder of one file per room, without any include.
FILES = {
    "src/README.md": MAP,
    "src/system/pipeline.h": "",
    "include/proximity_server/narrowphase/shape/shape.h": "",
    "src/narrowphase/shape/triangle.h": "",
    "src/scene/mesh/mesh.cpp": "",
    "src/scene/query/scene.cpp": "",
    "src/scene/query/pair_search.h": "",
    "src/tools/clearance/clearance.h": "",
    "src/node/system/process.h": "",
    "src/node/main.cpp": "",
    "src/demo/demo_motion.cpp": "",
}


class BrokenRules(unittest.TestCase):
    """What the check says of a small source folder in which one thing is wrong."""

    def found(self, files):
        with tempfile.TemporaryDirectory() as folder:
            for path, text in {**FILES, **files}.items():
                file = pathlib.Path(folder, path)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
            source = pathlib.Path(folder)
            return [*problems(source), *problems_within_rooms(source), *problems_of_order(source)]

    def test_includes_of_the_same_and_of_lower_rooms_are_right(self):
        self.assertEqual([], self.found({
            "src/scene/query/scene.cpp": '#include "scene/query/pair_search.h"\n'
                                         '#include "system/pipeline.h"\n'
                                         '#include "proximity_server/narrowphase/shape/shape.h"\n'
                                         "#include <vector>\n",
            "src/node/main.cpp": '#include "node/system/process.h"\n#include <proximity_server/ShapeRef.h>\n'}))

    def test_an_include_of_a_higher_room_is_named_with_both_rooms(self):
        self.assertEqual(
            ['src/scene/mesh/mesh.cpp: #include "scene/query/pair_search.h" runs back up from scene/mesh to scene/query'],
            self.found({"src/scene/mesh/mesh.cpp": '#include "scene/query/pair_search.h"'}))

    def test_a_room_stands_one_floor_above_what_it_includes(self):
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder)
            for path, text in {"src/README.md": MAP, "src/scene/mesh/mesh.h": '#include "system/pipeline.h"',
                               "src/scene/query/scene.cpp": '#include "scene/mesh/mesh.h"'}.items():
                (source / path).parent.mkdir(parents=True, exist_ok=True)
                (source / path).write_text(text)
            self.assertEqual({"scene/mesh": 1, "scene/query": 2}, floors(source))

    def test_the_node_includes_no_tool(self):
        found, = self.found({"src/node/main.cpp": '#include "tools/clearance/clearance.h"'})
        self.assertIn("node (node/main) and tools (tools/clearance) do not include each other", found)

    def test_the_demo_includes_no_tool(self):
        found, = self.found({"src/demo/demo_motion.cpp": '#include "tools/clearance/clearance.h"'})
        self.assertIn("demo (demo) and tools (tools/clearance) do not include each other", found)

    def test_a_private_header_is_of_its_layer_only(self):
        found, = self.found({"src/scene/mesh/mesh.cpp": '# include "narrowphase/shape/triangle.h"'})
        self.assertIn("is private to narrowphase (narrowphase/shape), and scene/mesh is not of it", found)

    def test_the_narrowphase_includes_no_header_of_the_system(self):
        found, = self.found({"src/narrowphase/shape/shape.cpp": '#include "system/pipeline.h"'})
        self.assertIn("is private to system (system), and narrowphase/shape is not of it", found)

    def test_a_header_in_angle_brackets_is_checked_too(self):
        found, = self.found({"src/scene/mesh/mesh.cpp": "#include <proximity_server/scene/gone.h>"})
        self.assertIn("include/proximity_server/scene/gone.h does not exist", found)

    def test_a_file_that_belongs_to_no_room_is_named(self):
        self.assertEqual(["src/scene/helpers.h belongs to no room"], self.found({"src/scene/helpers.h": ""}))

    def test_a_circle_of_units_is_told(self):
        self.assertEqual(["runs in a circle: scene/query/pair_search -> scene/query/scene -> scene/query/pair_search"], self.found({
            "src/scene/query/scene.cpp": '#include "scene/query/pair_search.h"',
            "src/scene/query/pair_search.h": '#include "proximity_server/scene/query/scene.h"',
            "include/proximity_server/scene/query/scene.h": ""}))

    def test_a_room_of_too_many_units_is_named(self):
        self.assertEqual([f"scene/mesh has {MOST_UNITS + 1} units"],
                         self.found({f"src/scene/mesh/unit_{i}.h": "" for i in range(MOST_UNITS)}))

    def test_an_include_of_ours_below_one_of_the_standard_is_named(self):
        text = '#include "scene/mesh/mesh.h"\n\n#include <vector>\n#include "system/pipeline.h"\n'
        self.assertEqual(["src/scene/mesh/mesh.cpp: system/pipeline.h stands too low"],
                         self.found({"src/scene/mesh/mesh.h": "", "src/scene/mesh/mesh.cpp": text}))

    def test_a_room_without_a_file_is_named(self):
        self.assertEqual(["the room scene/motion has no file"],
                         self.found({"src/README.md": MAP.replace("scene/query\n", "scene/query\nscene/motion\n")}))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
