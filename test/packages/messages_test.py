#!/usr/bin/env python3
"""The messages alone, as the package proximity-server-msgs installs them, are enough for who listens to the node, in C++ and in Python.

usage: messages_test.py BUILD_DIR --gtest_output=xml:FILE
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import rosunit

BUILD = pathlib.Path(sys.argv[1]).resolve()
PROJECT = """
cmake_minimum_required(VERSION 3.16)
project(listener CXX)
find_package(catkin REQUIRED COMPONENTS proximity_server)
if(catkin_LIBRARIES MATCHES proximity OR TARGET proximity_server::proximity_narrowphase)
  message(FATAL_ERROR "a library that is not there: ${catkin_LIBRARIES}")
endif()
add_library(listener OBJECT listener.cpp)
target_include_directories(listener PRIVATE ${catkin_INCLUDE_DIRS})
"""
SOURCE = """
#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#if __has_include(<proximity_server/narrowphase/signed_distance.h>)
#error the headers of the libraries are in another package
#endif
bool isClear(const proximity_server::Clearance& clearance) { return clearance.level == proximity_server::Clearance::CLEAR; }
"""
NOT_THERE = ("Eigen3", "diagnostic_updater", "dynamic_reconfigure", "roscpp", "tf2", "tf2_msgs", "visualization_msgs")


class Messages(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name).resolve()
        self.prefix = self.folder / "prefix"
        self.run_program("cmake", "--install", BUILD, "--component", "messages", "--prefix", self.prefix)

    def run_program(self, *words, **variables):
        result = subprocess.run([str(word) for word in words], cwd=self.folder, env={**os.environ, **variables}, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        self.assertEqual(0, result.returncode, result.stdout)
        return result.stdout

    def test_a_listener_in_cpp_finds_them_where_the_needs_of_the_node_are_not_there(self):
        (self.folder / "CMakeLists.txt").write_text(PROJECT)
        (self.folder / "listener.cpp").write_text(SOURCE)
        config, = self.prefix.rglob("proximity_serverConfig.cmake")
        self.run_program("cmake", "-S", ".", "-B", "build", f"-Dproximity_server_DIR={config.parent}",
                         *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in NOT_THERE))
        self.run_program("cmake", "--build", "build")

    def test_a_listener_in_python_finds_them(self):
        package, = self.prefix.rglob("dist-packages/proximity_server")
        program = "from proximity_server.msg import Clearance; import proximity_server.srv as srv; print(Clearance._type, srv.__file__)"
        printed = self.run_program(sys.executable, "-c", program, PYTHONPATH=str(package.parent))
        self.assertEqual(f"proximity_server/Clearance {package}/srv/__init__.py", printed.strip())

    def test_the_package_keeps_its_name_and_nothing_of_the_node_is_there(self):
        self.assertIn("<name>proximity_server</name>", (self.prefix / "share/proximity_server/package.xml").read_text())
        self.assertTrue((self.prefix / "share/proximity_server/msg/Clearance.msg").exists())
        self.assertEqual([], [path for path in self.prefix.rglob("*") if path.suffix in (".so", ".launch", ".yaml")])


if __name__ == "__main__":
    rosunit.unitrun("proximity_server", "messages_test", Messages)
