"""For `pip install ./src/python`: builds the module and its libraries without ROS, in build/pip, and packs them into one folder.

The environment variable PROXIMITY_BUILD names a finished build to take them from instead, by its absolute path.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile

import setuptools
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parents[2]
if not (ROOT / "package.xml").exists():
    sys.exit("pip before 21.3 copies this folder away from the checkout: pip install --upgrade pip")
MADE = os.environ.get("PROXIMITY_BUILD")
BUILD = pathlib.Path(MADE or ROOT / "build/pip")
if MADE and not (BUILD / "CMakeCache.txt").exists():
    sys.exit(f"PROXIMITY_BUILD={MADE} is no build")
OWN = BUILD / "setuptools"  # what setuptools writes, else beside this file
OWN.mkdir(parents=True, exist_ok=True)


def cmake(*words):
    subprocess.run(["cmake", *map(str, words)], check=True)


def build_module():
    try:
        import pybind11
        found = [f"-Dpybind11_DIR={pybind11.get_cmake_dir()}"]
    except ImportError:  # the one of the distribution, perhaps
        found = []
    cmake("-S", ROOT, "-B", BUILD, "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_DISABLE_FIND_PACKAGE_catkin=ON",
          f"-DPython3_EXECUTABLE={sys.executable}", *found)
    cmake("--build", BUILD, "--target", "proximity_python", "--parallel", os.cpu_count())


class Build(build_ext):
    def run(self):
        if not MADE:
            build_module()
        package = pathlib.Path(self.build_lib, "proximity")
        with tempfile.TemporaryDirectory() as prefix:
            for component in ("library", "python"):
                cmake("--install", BUILD, "--prefix", prefix, "--component", component)
            module = next(pathlib.Path(prefix).rglob("_native" + sysconfig.get_config_var("EXT_SUFFIX")), None)
            if not module:
                sys.exit(f"{BUILD} has no module for {sys.executable}")
            shutil.rmtree(package, ignore_errors=True)
            shutil.copytree(module.parent, package)
            for library in pathlib.Path(prefix, "lib").glob("libproximity_*.so"):
                shutil.copy(library, package)


setuptools.setup(
    name="proximity",
    version=re.search("<version>(.*)</version>", (ROOT / "package.xml").read_text())[1],
    description="Signed distances of robots with proven bounds, from numpy to numpy",
    license="BSD",
    python_requires=">=3.8",
    install_requires=["numpy"],
    ext_modules=[setuptools.Extension("proximity._native", [])],
    cmdclass={"build_ext": Build},
    options={"build": {"build_base": str(OWN)}, "egg_info": {"egg_base": str(OWN)}},
)
