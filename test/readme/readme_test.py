#!/usr/bin/env python3
"""Runs every block of every README.md, literally, and compares what it prints with what the README shows. Also looks
whether the files and headings that a document links to, and the files that it names, exist. Or runs the blocks of one
tutorial, a page below config/tutorials that begins with nothing but the built package.

usage: readme_test.py SOURCE_DIR BUILD_DIR [TUTORIAL] [--gtest_output=xml:FILE]

A block is indented by four spaces, or fenced. What is done with each is told by its first words, in BLOCKS; a block that is
not listed there fails. Commands run one after the other in one shell, in a folder that looks like a clone of the repository
with a build in it, beside a ROS master of its own and the moving robot of the demo. They are changed in nothing but what
CHEAPER lists. A line "..." of a README stands for any lines.
"""

import functools
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import rosunit

SOURCE, BUILD = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
PATIENCE = 120.0  # [s] nothing takes this long unless it is broken

# As if these packages were not there: narrowphase needs none of them.
WITHOUT = " ".join(f"-DCMAKE_DISABLE_FIND_PACKAGE_{package}=ON" for package in (
    "catkin", "console_bridge", "Boost", "nlohmann_json", "fcl", "Bullet", "ccd"))

# What a whole build takes too long for, and what is done instead.
CHEAPER = {
    # The build that this test runs from.
    "cmake -S . -B build -DCMAKE_BUILD_TYPE=Release && cmake --build build -j$(nproc)": "test -e build/devel/setup.bash",
    # Without ROS: all is configured, one source of narrowphase is compiled, and the libraries are installed; static, as the build of
    # this test has the shared ones. All other objects are those of that build, as neither layer knows ROS.
    "cmake -S . -B build -DBUILD_TESTING=ON && cmake --build build && cmake --build build --target test && cmake --install build":
        "cmake -S . -B without_ros -DBUILD_TESTING=ON -DCMAKE_DISABLE_FIND_PACKAGE_catkin=ON -DCMAKE_BUILD_TYPE=None "
        "-DBUILD_SHARED_LIBS=OFF -DCMAKE_INSTALL_PREFIX=$PWD/installed_without_ros && "
        "cmake --build without_ros --target narrowphase_headers && make -C without_ros/src/narrowphase shape/rigid_pose.o && "
        f"ar rcs without_ros/src/narrowphase/libproximity_narrowphase.a @{BUILD}/test/readme/objects_of_narrowphase && "
        f"ar rcs without_ros/src/scene/libproximity_scene.a @{BUILD}/test/readme/objects_of_scene && "
        "(cd without_ros && ctest -N) | grep signed_distance_test && "
        "cmake --install without_ros --component library && cmake --install without_ros --component development",
    # Narrowphase as where there is nothing but what it needs: it has the same sources, whose library was made just before.
    "cmake -S . -B build -DPROXIMITY_NARROWPHASE_ONLY=ON -DBUILD_TESTING=ON && cmake --build build && "
    "cmake --build build --target test && cmake --install build":
        "cmake -S . -B narrowphase -DPROXIMITY_NARROWPHASE_ONLY=ON -DBUILD_TESTING=ON -DCMAKE_BUILD_TYPE=None "
        f"-DBUILD_SHARED_LIBS=OFF -DCMAKE_INSTALL_PREFIX=$PWD/installed_narrowphase {WITHOUT} && "
        "(cd narrowphase && ctest -N) | grep narrowphase_closed_form_test && "
        "cp without_ros/src/narrowphase/libproximity_narrowphase.a narrowphase/src/narrowphase/ && cmake --install narrowphase",
    # The development space of the build of this test: find_package() takes it as it takes a prefix, see source_of_scene().
    "cmake -S proximity_server -B build && cmake --build build -j$(nproc) && cmake --install build --prefix ~/proximity":
        f"ln -s {BUILD}/devel ~/proximity",
}

# The folder that a tutorial needs beside the repository. Without it the test of the tutorial is skipped.
EXAMPLE_ROBOTS = SOURCE.parent / "shared" / "robots" / "example-robot-data"
NEEDS = {"ur5.md": EXAMPLE_ROBOTS}

# The same without a Slurm: one task, as Slurm would start it.
SLURM_TASK = re.compile(r"^sbatch --array=1-8 ")

# Options with which a command ends with an exit code of its own; then the README shows standard error too.
EXIT_CODES = {"--assert-above": 2, "--refuting": 2, "--second-opinion": 3}

# What this test writes beside the examples.
OWN_FILES = {"environment", "gate.py", "installed", "installed_narrowphase", "installed_without_ros", "narrowphase", "project",
             "session.txt", "too_close.test", "without_ros"}

# Commands that run until somebody ends them.
ENDLESS = ("roslaunch ", "rostopic echo ")


def blocks(path):
    """(line number, kind, text) of every block: kind is the word of the fence, or "indented"."""
    lines = path.read_text().splitlines()
    number = 0
    while number < len(lines):
        start = number
        fence = re.match(r"```(\w*)", lines[number])
        if fence:
            number = lines.index("```", start + 1)
            yield start + 1, fence[1], "\n".join(lines[start + 1:number])
        elif lines[number].startswith("    ") and (number == 0 or not lines[number - 1].strip()):
            while number + 1 < len(lines) and (lines[number + 1].startswith("    ") or not lines[number + 1].strip()):
                number += 1
            yield start + 1, "indented", "\n".join(line[4:] for line in lines[start:number + 1]).rstrip()
        number += 1


class Shell:
    """Runs scripts in bash one after the other; each begins in the environment in which the one before it ended."""

    def __init__(self, folder, environment):
        self.folder, self.environment = folder, environment

    def run(self, script):
        """What it printed to standard output; raises AssertionError with all of its output where it fails."""
        dump = self.folder / "environment"
        # The shell does not end where a command before the last && fails: its status is looked at behind the script.
        checked = f"set -e -o pipefail\n{script}\n[ $? = 0 ]\nenv -0 >{dump}"
        result = subprocess.run(["bash", "-c", checked], cwd=self.folder, text=True,
                                env=self.environment, stdin=subprocess.DEVNULL, capture_output=True, timeout=5 * PATIENCE)
        if result.returncode != 0:
            output = re.sub(r"\x1b\[[0-9;]*m", "", result.stdout + result.stderr)  # no colours in the result file
            raise AssertionError(f"exit code {result.returncode}: {script}\n{output}")
        entries = dump.read_text().split("\0")
        self.environment = dict(entry.split("=", 1) for entry in entries if "=" in entry)
        return result.stdout

    def start(self, command, output):
        """A process group that runs the command until stop()."""
        return subprocess.Popen(["bash", "-c", f"exec {command}"], cwd=self.folder, env=self.environment,
                                start_new_session=True, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)


def stop(process):
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
    process.wait(timeout=PATIENCE)


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


def answers(port):
    with socket.socket() as probe:
        return probe.connect_ex(("localhost", port)) == 0


def wait_until(holds, what):
    deadline = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > deadline:
            raise AssertionError(f"in vain: {what}")
        time.sleep(0.1)


NUMBER = re.compile(r"(?<![A-Za-z_\d.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def says(printed, shown):
    """Whether a line is the one that is shown, or begins with what is shown before "...". Numbers of a search may differ by
    1e-6, its tolerance: rounding is not the same on each processor."""
    printed, shown = printed.rstrip(), shown.rstrip()
    if shown.endswith("..."):
        return printed.startswith(shown[:-3])
    if NUMBER.split(printed) != NUMBER.split(shown):
        return False
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(shown))
    return all(abs(float(a) - float(b)) <= 1e-6 for a, b in pairs)


def like_a_clone(folder):
    """A folder with all that the repository holds, by links, and with the build."""
    folder.mkdir()
    for path in SOURCE.iterdir():
        if path.name not in ("build", ".git"):
            (folder / path.name).symlink_to(path)
    (folder / "build").symlink_to(BUILD)
    return folder


class Document(unittest.TestCase):
    """The blocks, in their order, become the test cases of a class that is derived from it. This one has what is done with them."""

    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = like_a_clone(pathlib.Path(temporary.name, "proximity_server").resolve())
        cls.processes = []
        cls.addClassCleanup(lambda: [stop(process) for process in reversed(cls.processes)])
        kept = {name: os.environ[name] for name in ("PATH", "LANG", "CMAKE_CXX_COMPILER_LAUNCHER") if name in os.environ}
        # What a user has set of his own: it must outlive the commands.
        (cls.folder.parent / "robots").mkdir()
        cls.own_packages = str(cls.folder.parent / "robots")
        cls.port = free_port()
        cls.shell = Shell(cls.folder, {
            **kept, "HOME": str(cls.folder.parent), "ROS_PACKAGE_PATH": cls.own_packages, "ROS_HOSTNAME": "localhost",
            "ROS_HOME": str(cls.folder.parent / "ros"), "ROS_MASTER_URI": f"http://localhost:{cls.port}"})

    @classmethod
    def start(cls, shell, command):
        """Starts it, for the rest of the test; returns the file of its output."""
        output = cls.folder.parent / f"output_{len(cls.processes)}"
        with open(output, "w") as file:
            cls.processes.append(shell.start(command, file))
        return output

    def picture(self, text):
        """Nothing: it is no command."""

    def commands(self, text):
        for line in text.splitlines():
            command = SLURM_TASK.sub("SLURM_ARRAY_TASK_ID=1 bash ", CHEAPER.get(line, line))
            if command.startswith(ENDLESS):
                self.endless(command)
            else:
                self.shell.run(command)

    def engines(self, text):
        if not shutil.which("parallel"):
            self.skipTest("there is no GNU Parallel: ./dev packages engines")
        self.commands(text)

    def endless(self, command):
        """It is right when it prints, and goes on. A launch prints nothing as long as its nodes have no warning: it is right
        when there is a ROS master."""
        output = self.start(self.shell, command)
        process = self.processes[-1]
        begun = (lambda: answers(self.port)) if command.startswith("roslaunch") else (lambda: output.stat().st_size)
        wait_until(lambda: begun() or process.poll() is not None, command)
        self.assertIsNone(process.poll(), output.read_text())
        if command.startswith("rostopic"):
            wait_until(lambda: "\n---" in output.read_text() or process.poll() is not None, f"a message: {command}")
            self.assertNotIn("ERROR", output.read_text())
            stop(self.processes.pop())

    def bridge(self, text):
        """It prints nothing as long as all is well: it is right when it listens to MoveIt's topic, and goes on."""
        self.start(self.shell, text)
        topic = text.partition("collision_object:=")[2] or "/collision_object"
        listens = lambda: "/moveit_stream" in self.shell.run(f"rostopic info {topic} || true")
        wait_until(listens, text)
        self.assertIsNone(self.processes[-1].poll())

    def node(self, text):
        """It starts a ROS master too, and is right when the clearance comes."""
        self.start(self.shell, text)
        wait_until(lambda: answers(self.port), "the ROS master")
        self.wait_for_clearance()

    def wait_for_clearance(self):
        self.shell.run(f"timeout {PATIENCE:g} rostopic echo -n 1 /proximity_server/clearance/cycle")

    def workspace(self, text):
        self.assertNotRegex(commands_of_all(), r"(?m)(-o (\./)?devel/lib/proximity_server/\w+_test|^all: test/)",
                            "the build builds the tests")
        self.commands(text)
        self.assertIn(self.own_packages, self.shell.environment["ROS_PACKAGE_PATH"].split(":"))
        self.wait_for_clearance()

    def service_calls(self, text):
        for line in text.splitlines():
            if line.startswith("rosservice "):
                self.assertIn("success: True", self.shell.run(line))
            else:
                self.commands(line)

    def shown_output(self, text):
        command, *shown = text.replace("$ ", "", 1).splitlines()
        for option, code in EXIT_CODES.items():
            if option in command:
                command = f"{{ {command}; }} 2>&1 || test $? = {code}"
        printed = self.shell.run(command).splitlines()
        position, gap = 0, False
        for line in shown:
            if line == "...":
                gap = True
                continue
            found = [i for i in range(position, len(printed)) if says(printed[i], line) and (gap or i == position)]
            self.assertTrue(found, f"is not printed: {line}\nprinted from there on:\n" + "\n".join(printed[position:]))
            position, gap = found[0] + 1, False
        self.assertTrue(gap or position == len(printed), f"not shown: {printed[position:]}")

    def dev(self, text):
        """Not run, each is minutes: ./dev help knows each command and option. CI runs ./dev test; ./dev demo is for people."""
        known = self.shell.run("./dev help")
        for line in text.splitlines():
            words = line.partition("#")[0].partition("./dev ")[2].split()  # variables may stand before it
            self.assertRegex(known, rf"(?m)^  {words[0]}\b")
            for option in (word for word in words if word.startswith("--")):
                self.assertIn(option, known)

    def file(self, text):
        """Becomes the file that the comment in its first line names."""
        path = self.shell.folder / re.match(r"\W+([\w./]+)", text)[1]
        path.parent.mkdir(exist_ok=True)
        path.write_text(text + "\n")

    def file_of_test(self, text):
        """Becomes a file of a package, which passes; with another minimum it fails with the worst moment."""
        package = pathlib.Path(self.own_packages, "my_robot")
        (package / "test").mkdir(parents=True)
        (package / "package.xml").write_text(
            '<package format="2"><name>my_robot</name><version>0.0.0</version><description>A robot</description>'
            '<maintainer email="me@example.org">Me</maintainer><license>BSD</license></package>')
        (package / "test" / "keeps_clear.test").write_text(text)
        (package / "test" / "too_close.test").write_text(text.replace('name="minimum" value="0.05"', 'name="minimum" value="0.06"'))

    def python_session(self, text):
        """Python prints what the block shows; warnings are left out."""
        session = self.folder / "session.txt"
        session.write_text(text)
        self.shell.run(f"python3 -W ignore -m doctest {session}")

    def file_of_objects(self, text):
        """Becomes a file for the commands behind it; the gtest of its room reads that of config/README.md."""
        (self.folder / "cell.yaml").write_text(text + "\n")

    def parameters(self, text):
        """Becomes parameters of the demo's node, which takes them."""
        file = self.folder / "parameters.yaml"
        file.write_text(text + "\n")
        names = [line.split(":")[0] for line in text.splitlines()]
        reload = "rosservice call /proximity_server/reload"
        printed = self.shell.run(f"rosparam load {file} /proximity_server && {reload}")
        file.unlink()
        self.assertIn("success: True", printed)
        self.shell.run(" && ".join(f"rosparam delete /proximity_server/{name}" for name in names) + f" && {reload}")

    def inequalities_of_icub(self, text):
        """Become a file for that robot, if it is there."""
        robot = EXAMPLE_ROBOTS / "robots" / "icub_description" / "robots" / "icub.urdf"
        file = self.folder / "cables.yaml"
        file.write_text(text + "\n")
        if robot.exists():
            self.shell.run(f"ROS_PACKAGE_PATH={EXAMPLE_ROBOTS.parent} build/devel/lib/proximity_server/clearance {robot} "
                           f"--joint-inequalities {file} --sample 100 --quiet")
        file.unlink()

    def rostest(self, text):
        printed = self.shell.run(text)
        self.assertIn("[my_robot.rosunit-robot_keeps_clear/test_minimum][passed]", printed)
        self.assertIn("[my_robot.rosunit-hands_keep_off_the_head/test_minimum][passed]", printed)
        with self.assertRaises(AssertionError) as failure:
            self.shell.run(text.replace("keeps_clear", "too_close"))
        self.assertRegex(str(failure.exception), r"not proven to stay above the minimum of 0\.06 m of all pairs\. Worst: at "
                         r"\d+\.\d+ s torso - \w+_upper_arm: distance 0\.0564\d+ m, bounds \[0\.0564\d+, 0\.0564\d+\], "
                         r"level CLEAR \(threshold 0\.05 m\); joints: .*left_elbow_flex=")

    def gate(self, text):
        """Becomes a program, which lets the robot move, holds it at silence and at STOP, and lets it move again."""
        program = self.folder / "gate.py"
        program.write_text(text)
        log = self.start(self.shell, f"python3 {program}")
        echo = self.start(self.shell, "rostopic echo -p /may_move")
        says = lambda value: echo.read_text().rstrip().endswith(f",{value}")
        settings = lambda text: f'rosrun dynamic_reconfigure dynparam set /proximity_server "{{{text}}}"'
        wait_until(lambda: says(1), "may_move")
        for hold, resume, reason in (
                ("rosservice call /proximity_server/enable_monitor false", "rosservice call /proximity_server/enable_monitor true",
                 "there is no clearance"),
                (settings("warn_distance: 1.0, stop_distance: 1.0"), settings("warn_distance: 0.05, stop_distance: 0.0"), " m")):
            self.shell.run(hold)
            wait_until(lambda: says(0), hold)
            self.assertIn("The robot holds: ", log.read_text())
            self.assertIn(reason, log.read_text())
            self.shell.run(resume)
            wait_until(lambda: says(1), resume)
        self.shell.run(settings("stop_distance: 0.02"))
        for _ in range(2):
            stop(self.processes.pop())

    def find_package(self, text):
        """Kept for the sources beside it."""
        type(self).cmake_snippet = text

    def source(self, text):
        """A program of both snippets, with each package that there is; and it answers what the comment says. The next one is made
        with it."""
        type(self).source_of_narrowphase = text

    def source_of_scene(self, text):
        # Of the build of this test. All of it goes where it is told to, and nothing into the prefix that was configured.
        prefix = self.folder / "installed" / "prefix"
        self.shell.run(f"DESTDIR=$PWD/installed cmake --install {BUILD} --prefix /prefix && "
                       "test \"$(ls -A installed)\" = prefix && test -e installed/prefix/setup.sh -a -e installed/prefix/.catkin")
        project = self.folder / "project"
        project.mkdir()
        head, using, rest = re.split(r"(using namespace [\w:]+;\n)", self.source_of_narrowphase)
        (project / "mine.cpp").write_text(
            f"{head}#include <cmath>\n{using}\nint main() {{\n{rest}\n"
            "return std::abs(answer.distance - 0.6) < 1e-9 && std::abs(answer.point_a.x() - 0.2) < 1e-9 && "
            "std::abs(answer.point_b.x() - 0.8) < 1e-9 ? 0 : 1;\n}\n")
        (project / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.16)\nproject(mine CXX)\nset(CMAKE_CXX_STANDARD 17)\nadd_executable(mine mine.cpp)\n"
            f"{self.cmake_snippet}\n"
            "if(TARGET proximity_server::proximity_scene)\n  add_executable(of_scene of_scene.cpp)\n"
            "  target_link_libraries(of_scene PRIVATE proximity_server::proximity_scene)\nendif()\n")
        head, rest = re.split(r"(?m)^using namespace proximity_server;$", text)
        (project / "of_scene.cpp").write_text(f"{head}using namespace proximity_server;\nint main() {{\n{rest}\n}}\n")
        for name, path, options, clients in (
                ("catkin", prefix, "", ("mine", "of_scene")),
                ("devel", BUILD / "devel", "", ("mine", "of_scene")),
                ("static", self.folder / "installed_without_ros", "", ("mine", "of_scene")),
                ("narrowphase", self.folder / "installed_narrowphase", WITHOUT, ("mine",))):
            self.shell.run(f"cmake -S project -B project/{name} -DCMAKE_PREFIX_PATH={path} {options} && "
                           f"cmake --build project/{name} && " + " && ".join(f"project/{name}/{client}" for client in clients))
            self.assertEqual("of_scene" in clients, (project / name / "of_scene").exists(), name)
            cache = (project / name / "CMakeCache.txt").read_text()
            self.assertIn(f"proximity_server_DIR:PATH={path}", cache)
        printed = subprocess.check_output(project / "catkin" / "of_scene", text=True)
        self.assertTrue(says(printed, "".join(f"{line}\n" for line in re.findall(r";  // (.*)", text))), printed)
        # What is installed is found by rosrun and rostest too.
        self.shell.run(f"test -x {prefix}/lib/proximity_server/clearancetest")
        self.shell.run(f"CMAKE_PREFIX_PATH={prefix} ROS_PACKAGE_PATH={prefix}/share rosrun proximity_server clearance --help")


class Readmes(Document):
    """All of them, beside a ROS master and the moving robot of the demo."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        robot = Shell(cls.folder, dict(cls.shell.environment))
        robot.run("source build/devel/setup.bash")
        cls.start(robot, f"roslaunch -p {cls.port} {SOURCE}/test/readme/robot.launch")
        wait_until(lambda: answers(cls.port), "the ROS master")  # else the next roslaunch would start another one

    def test_what_the_examples_leave_is_ignored_by_git(self):
        """The last test case, by its name."""
        if not shutil.which("git"):
            self.skipTest("there is no git")
        left = {path.name for path in self.folder.iterdir() if not path.is_symlink()} - OWN_FILES
        if "states.npy" not in left:
            self.skipTest("the examples did not run before")
        clone = self.folder.parent / "clone"
        subprocess.run(["git", "init", "-q", clone], check=True)
        shutil.copy(SOURCE / ".gitignore", clone)  # git follows no link to it
        names = [name + "/" if (self.folder / name).is_dir() else name for name in sorted(left)]
        ignored = subprocess.run(["git", "-C", clone, "check-ignore", *names], stdout=subprocess.PIPE, text=True, check=False).stdout
        self.assertEqual(left, {name.rstrip("/") for name in ignored.split()})

    def test_links_of_every_document_lead_to_a_file_and_a_heading(self):
        self.assertEqual({}, {str(path): found for path in documents() if (found := list(broken_links(path)))})

    def test_the_top_readme_takes_ten_kilobytes_at_most(self):
        self.assertLessEqual((SOURCE / "README.md").stat().st_size, 10_000)

    def test_files_that_a_document_names_exist(self):
        self.assertEqual({}, {str(path): found for path in documents() if (found := list(missing_paths(path)))})

    def test_the_way_of_a_newcomer_leads_to_an_answer(self):
        kept = {name: os.environ[name] for name in ("PATH", "LANG", "CMAKE_CXX_COMPILER_LAUNCHER") if name in os.environ}
        result = subprocess.run([SOURCE / "test" / "readme" / "newcomer" / "newcomer.sh", BUILD], capture_output=True, text=True,
                                env={**kept, "HOME": str(self.folder.parent), "ROS_HOSTNAME": "localhost"}, check=False,
                                timeout=5 * PATIENCE)
        self.assertEqual(0, result.returncode, (result.stdout + result.stderr)[-5000:])

    def test_a_tutorial_takes_eight_kilobytes_at_most(self):
        self.assertEqual([], [path.name for path in tutorials() if path.stat().st_size > 8_000])


class Tutorial(Document):
    """One of them, in the folder that has the clone, in a shell for the built package. It starts its own master."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        if EXAMPLE_ROBOTS.exists():
            pathlib.Path(cls.own_packages, EXAMPLE_ROBOTS.name).symlink_to(EXAMPLE_ROBOTS)
        cls.shell.run("source build/devel/setup.bash && export PATH=$PWD/build/devel/lib/proximity_server:$PATH && "
                      f"export ROS_PACKAGE_PATH=$ROS_PACKAGE_PATH:/usr/share:{cls.own_packages}")
        cls.shell.folder = cls.folder.parent


def commands_of_all():
    """How the target `all` is built, a line each: its commands with Ninja, its rules with make."""
    if (BUILD / "build.ninja").exists():
        return subprocess.check_output(["ninja", "-C", BUILD, "-t", "commands", "all"], text=True)
    return (BUILD / "CMakeFiles" / "Makefile2").read_text()


def documents():
    """Every document in Markdown, but those of which others are made."""
    return readmes() + tutorials() + sorted(
        path for path in set(SOURCE.glob("**/[A-Z]*.md")) - set(readmes()) if ".template" not in path.name
        and path.relative_to(SOURCE).parts[0] != "build")


def tutorials():
    return sorted((SOURCE / "config" / "tutorials").glob("*.md"))


def readmes():
    """Every README.md of the repository, the top one first, and the pages about uncertainties and cameras; their
    blocks run in this order.
    """
    return sorted(SOURCE.glob("README.md")) + sorted(
        path for name in ("README.md", "SENSED.md", "UNCERTAINTY.md") for path in SOURCE.glob(f"*/**/{name}")
        if path.relative_to(SOURCE).parts[0] != "build")


def anchors(path):
    """The anchors of the headings of a document, as a browser of the repository makes them."""
    headings = re.findall(r"(?m)^#+ (.*)$", path.read_text())
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken_links(path):
    """The relative links of a document that lead to no file, or to no heading of a document."""
    for link in re.findall(r"\]\(([^)\s]+)\)", path.read_text()):
        file, _, anchor = link.partition("#")
        target = (path.parent / file).resolve() if file else path
        if re.match(r"\w+:", link):
            continue
        if not target.exists() or (anchor and anchor not in anchors(target)):
            yield link


@functools.lru_cache
def names_of_sources():
    """The names of all source files of the repository, without their folders."""
    return {path.name for tree in ("include", "src", "test") for path in (SOURCE / tree).rglob("*.*")}


def missing_paths(path):
    """The files that a document names and that are not there: `src/...` from the top of the repository, and `shape.cpp` in any folder."""
    text = path.read_text()
    for name in re.findall(r"`((?:src|include|test|msg|srv|config|launch)/[\w./-]+)`", text):
        if not (SOURCE / name).exists():
            yield name
    for name in re.findall(r"`(\w+\.(?:cpp|h|pyi?))`", text):
        if name not in names_of_sources():
            yield name


# What is done with the blocks that begin like this.
BLOCKS = (
    ("system/layer_guard\nsystem", Document.picture),  # the order of the rooms, which rooms_test reads
    ("./dev ", Document.dev),
    ("cmake -S . -B build -DCMAKE_BUILD_TYPE=Release", Document.workspace),
    ("rosservice call ", Document.service_calls),
    (("rostopic echo ", "rosparam set "), Document.commands),
    ("roslaunch proximity_server moveit_stream.launch", Document.bridge),
    ("rosrun proximity_server moveit_stream ", Document.bridge),
    ("roslaunch ", Document.node),
    ("rosrun dynamic_reconfigure ", Document.commands),
    ("export PATH=", Document.commands),
    (("export UR5=", "export DEMO="), Document.commands),
    ("sed -i ", Document.commands),
    (("# ur5_proximity/", "<!-- ur5_proximity/", "# mine/", "// mine/"), Document.file),
    ("echo : > hosts.txt", Document.engines),
    ("sbatch ", Document.engines),  # merges the parts of the one before
    ("$ ", Document.shown_output),
    (">>> ", Document.python_session),
    ("<launch>", Document.file_of_test),
    ("objects:", Document.file_of_objects),
    (("pair_stop_distance:", "joint_uncertainty:", "joint_inequalities:", "tracked:", "sensed:"), Document.parameters),
    ("- -347 deg", Document.inequalities_of_icub),
    ("rostest ", Document.rostest),
    ("cmake -S ", Document.commands),
    ("#!/usr/bin/env python3\n\"\"\"Publishes on `may_move`", Document.gate),
    ("find_package(proximity_server", Document.find_package),
    ("#include <proximity_server/", Document.source),
    ("#include <iostream>", Document.source_of_scene),
)


def unknown(text):
    """A test case that fails."""

    def check(self):
        self.fail(f"readme_test.py does not know what to do with this block:\n{text}")

    return check


def known(function, text):
    return lambda self: function(self, text)


def add_blocks(test_case, paths):
    """Each block of the documents becomes a test case; unittest runs them in the order of their names."""
    for file, path in enumerate(paths):
        needed = NEEDS.get(path.name, SOURCE)
        for line, _, text in blocks(path):
            functions = [function for beginning, function in BLOCKS if text.startswith(beginning)]
            name = path.relative_to(SOURCE).with_suffix("").as_posix().replace("/", "_")
            case = known(functions[0], text) if functions else unknown(text)
            skipped = unittest.skipUnless(needed.exists(), f"there is no ../{needed.relative_to(SOURCE.parent)}")
            setattr(test_case, f"test_{file:02}_{name}_line_{line:04}", skipped(case))


if __name__ == "__main__":
    tutorial = [SOURCE / argument for argument in sys.argv[3:] if argument.endswith(".md")]
    if tutorial:
        add_blocks(Tutorial, tutorial)
        rosunit.unitrun("proximity_server", f"tutorial_{tutorial[0].stem}_test", Tutorial)
    else:
        add_blocks(Readmes, readmes())
        rosunit.unitrun("proximity_server", "readme_test", Readmes)
