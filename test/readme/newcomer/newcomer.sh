#!/usr/bin/env bash
# The way of somebody who has a catkin workspace, and another python3 first on PATH: he builds the package without a build type,
# installs it, and uses library, node, objects and tests from a package of his own.
#
#   newcomer.sh [BUILD]    BUILD: takes what this build of the package has made; nothing of the package is compiled then, which takes
#                          15 minutes
set -euo pipefail
here=$(readlink -f "$(dirname "$0")")
source=$(readlink -f "$here/../../..")
build=${1:+$(readlink -f "$1")}
folder=$(mktemp -d)
node=
finish() {
  if [ -n "$node" ]; then
    kill "$node" 2>/dev/null || true
    wait "$node" || true
  fi
  rm -rf "$folder"
}
trap finish EXIT

export ROS_HOME=$folder/ros ROS_TEST_RESULTS_DIR=$folder/results

step() { echo "--- $*"; }

wait_for() {  # wait_for <what> <command>: at most a minute
  local what=$1 i
  shift
  for ((i = 0; i < 600; ++i)); do
    if "$@" >/dev/null 2>&1; then return; fi
    sleep 0.1
  done
  echo "in vain: $what" >&2
  exit 1
}

# A Python without catkin_pkg, as those of pyenv and conda.
mkdir -p "$folder/python"
printf '#!/bin/sh\nexec /usr/bin/python3 -I -S "$@"\n' >"$folder/python/python3"
chmod +x "$folder/python/python3"
if "$folder/python/python3" -c 'import catkin_pkg' 2>/dev/null; then echo "this Python was to have no catkin_pkg" >&2; exit 1; fi

step "README's build, with that Python first on PATH"
PATH=$folder/python:$PATH cmake -S "$source" -B "$folder/build" -DCMAKE_BUILD_TYPE=Release
PATH=$folder/python:$PATH cmake -S "$source" -B "$folder/build" -DPYTHON_EXECUTABLE="$folder/python/python3" |
  grep "Using PYTHON_EXECUTABLE: /usr/bin/python3"

step "a workspace without a build type"
workspace=$folder/workspace
mkdir -p "$workspace/src"
ln -s "$source" "$workspace/src/proximity_server"
ln -s /usr/share/catkin/cmake/toplevel.cmake "$workspace/src/CMakeLists.txt"
taken=()
if [ -n "$build" ]; then taken=(-DCMAKE_BUILD_WITH_INSTALL_RPATH=ON); fi  # as programs are copied, not linked
cmake -S "$workspace/src" -B "$workspace/build" "-DCATKIN_DEVEL_PREFIX=$workspace/devel" "-DCMAKE_INSTALL_PREFIX=$workspace/install" \
  "${taken[@]}"
if [ -n "$build" ]; then
  tar -C "$build/devel" -c . | tar -C "$workspace/devel" -x --skip-old-files
else
  cmake --build "$workspace/build" -j "$(nproc)"
fi
cmake --install "$workspace/build"

step "a package of his own, in a workspace above the installed one"
set +u
# shellcheck source=/dev/null
source "$workspace/install/setup.bash"
set -u
mkdir -p "$folder/own/src"
cp -r "$here/client" "$folder/own/src/client"
ln -s /usr/share/catkin/cmake/toplevel.cmake "$folder/own/src/CMakeLists.txt"
cmake -S "$folder/own/src" -B "$folder/own/build" "-DCATKIN_DEVEL_PREFIX=$folder/own/devel" "-DPYTHON_EXECUTABLE=/usr/bin/python3"
cmake --build "$folder/own/build" -j "$(nproc)"
set +u
# shellcheck source=/dev/null
source "$folder/own/devel/setup.bash"
set -u
ROS_PACKAGE_PATH=$ROS_PACKAGE_PATH:/usr/share

step "a project without catkin"
mkdir "$folder/plain"
cat >"$folder/plain/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.16)
project(plain CXX)
find_package(proximity_server REQUIRED)
add_executable(links links.cpp)
target_link_libraries(links PRIVATE proximity_server::proximity_scene)
CMAKE
cat >"$folder/plain/links.cpp" <<'CPP'
#include <proximity_server/scene/loading/load_robot_model.h>
int main() {
  using namespace proximity_server::scene;
  return loadRobotModel("<robot name='r'><link name='a'/></robot>", packageResolver({})).links.size() == 1 ? 0 : 1;
}
CPP
env -u CMAKE_PREFIX_PATH cmake -S "$folder/plain" -B "$folder/plain/build" \
  "-Dproximity_server_DIR=$workspace/install/share/proximity_server/cmake"
cmake --build "$folder/plain/build"
"$folder/plain/build/links"

step "a test of his robot"
rostest client keeps_clear.test

step "the node, an object, and a question"
port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("localhost", 0)); print(s.getsockname()[1])')
export ROS_MASTER_URI=http://localhost:$port ROS_HOSTNAME=localhost
roslaunch -p "$port" client robot.launch >"$folder/node.log" 2>&1 &
node=$!
wait_for "the node" rosservice call /proximity_server/apply_objects "{changes: {changes: []}}"
rosrun client closest
rosservice call /proximity_server/apply_objects "{changes: {changes: [{operation: 0, id: ball,
  header: {frame_id: head}, pose: {position: {z: 0.285}}, primitives: [{type: 2, dimensions: [0.01]}]}]}}" | grep "success: True"
rosrun client closest | grep "head - ball: 0.005 m"
