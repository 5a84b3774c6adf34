#!/usr/bin/env python3
"""What `make install` installs of the module works beside the installed libraries, and wherever both are moved to."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import cases
from cases import BALLS, BUILD

# Prints the files of the module and of its libraries.
PROGRAM = f'''
import proximity
proximity.Robot.from_text("""{BALLS}""", only_pairs=[("base", "arm")]).minimum([0.0, 0.0, 0.0])
print(proximity.__file__)
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
            self.assertEqual([], [path for path in printed if not path.startswith(f"{moved}/")])
            self.assertTrue(any("_native" in path for path in printed))
            self.assertEqual({"__init__.py", "_native.pyi", "_shapes.py", "py.typed"},
                             {path.name for path in package.parent.iterdir() if path.suffix != ".so" and path.is_file()})
            self.assertEqual(["joint_space.py"], [path.name for path in moved.rglob("examples/*")])


if __name__ == "__main__":
    cases.main()
