#!/usr/bin/env python3
"""What `make install` and pip install of the module works: beside the installed libraries, wherever both are moved to, and in a virtual
environment."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import cases
from cases import BALLS, BUILD

# Prints how deep two balls are in each other, and the files of the module and of its libraries.
PROGRAM = f'''
import proximity
robot = proximity.Robot.from_text("""{BALLS.replace('"2 0 0"', '"1.1 0 0"')}""", only_pairs=[("base", "arm")])
print(round(float(robot.minimum([0.0, 0.0, 0.0])["distance"]), 9), proximity.__file__)
print(*sorted({{line.split()[-1] for line in open("/proc/self/maps") if "libproximity_" in line or "_native" in line}}), sep="\\n")
'''


class Installation(unittest.TestCase):
    def test_the_installed_module_uses_the_installed_libraries(self):
        with tempfile.TemporaryDirectory() as folder:
            prefix = pathlib.Path(folder).resolve() / "prefix"
            for component in ("library", "python"):
                subprocess.run(["cmake", "--install", BUILD, "--component", component, "--prefix", prefix], check=True,
                               stdout=subprocess.DEVNULL)
            moved = prefix.rename(prefix.with_name("moved"))
            package, = moved.rglob("proximity/__init__.py")
            environment = {name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"}
            printed = subprocess.run([sys.executable, "-c", PROGRAM], env={**environment, "PYTHONPATH": package.parents[1]}, text=True,
                                     check=True, capture_output=True).stdout.split()
            self.assertEqual("-0.2", printed.pop(0))
            self.assertEqual([], [path for path in printed if not path.startswith(f"{moved}/")])
            self.assertTrue(any("_native" in path for path in printed))
            self.assertEqual({"__init__.py", "_native.pyi", "_shapes.py", "py.typed"},
                             {path.name for path in package.parent.iterdir() if path.suffix != ".so" and path.is_file()})
            self.assertEqual(["joint_space.py"], [path.name for path in moved.rglob("examples/*")])

    @unittest.skipIf(cases.IS_SANITIZED, "the Python of the virtual environment would not be the instrumented one")
    def test_pip_installs_the_module_into_a_virtual_environment(self):
        for name in ("setuptools", "wheel", "pip"):
            if not importlib.util.find_spec(name):
                self.skipTest(f"there is no {name} for {sys.executable}")
        version = importlib.import_module("pip").__version__
        if int(version.split(".")[0]) < 22:
            self.skipTest(f"pip {version} copies src/python away from the checkout")
        with tempfile.TemporaryDirectory() as folder:
            python = pathlib.Path(folder).resolve() / "bin/python"
            subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", folder], check=True)
            environment = {**os.environ, "PYTHONPATH": "", "PROXIMITY_BUILD": BUILD}
            environment.pop("LD_LIBRARY_PATH", None)

            def run(*words):
                return subprocess.run([python, *words], env=environment, cwd=folder, text=True, check=True, stdout=subprocess.PIPE).stdout
            run("-m", "pip", "install", "--quiet", "--no-build-isolation", "--no-index", cases.SOURCE / "src/python")
            distance, *files = run("-c", PROGRAM).split()
            self.assertEqual("-0.2", distance)
            self.assertEqual([], [path for path in files if not path.startswith(f"{python.parents[1]}/")])


if __name__ == "__main__":
    cases.main()
