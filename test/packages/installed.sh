#!/usr/bin/env bash
# Installs the packages of ./dev package into a fresh system, uses them as a newcomer does, and removes them again.
#
#   installed.sh FOLDER    FOLDER: the packages. For a fresh chroot, as root: it installs and removes packages.
set -euo pipefail
packages=$(readlink -f "$1")
folder=$(mktemp -d)
export HOME=$folder ROS_HOSTNAME=localhost ROS_MASTER_URI=http://localhost:11797 DEBIAN_FRONTEND=noninteractive
node=
finish() {
  if [ -n "$node" ]; then kill -INT "$node" 2>/dev/null || true; wait "$node" || true; fi
  rm -rf "$folder"
}
trap finish EXIT

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

everything() { find /usr /etc /opt /home -xdev | sort; }

grep -q localhost /etc/hosts 2>/dev/null || echo "127.0.0.1 localhost" >>/etc/hosts  # a fresh chroot has none

step "the messages alone"
apt-get update -qq
apt-get install -qq --no-install-recommends "$packages"/proximity-server-msgs_*.deb >/dev/null
python3 -c "from proximity_server.msg import Clearance; print(Clearance._md5sum)"
if dpkg -s libroscpp-dev >/dev/null 2>&1; then echo "they bring roscpp" >&2; exit 1; fi

step "what they depend on"
# Their own dependencies stay, so that only our files differ afterwards.
apt-get install -qq --no-install-recommends "$packages"/*.deb g++ make cmake man-db >/dev/null
dpkg --purge libproximity-server-dev python3-proximity proximity-server proximity-server-msgs libproximity-server >/dev/null
everything >"$folder/before"

step "installed"
apt-get install -qq "$packages"/*.deb >/dev/null

step "the demo, and a question to it"
roslaunch -p 11797 proximity_server demo.launch rviz:=false >"$folder/demo.log" 2>&1 &
node=$!
ask() { rosservice call /proximity_server/minimum_distance "{a: {link: left_hand}, b: {link: right_hand}}" >"$folder/answer"; }
answers() { ask && grep -q "success: True" "$folder/answer"; }  # not yet without transforms
wait_for "an answer of the node" answers
grep -w distance "$folder/answer"
kill -INT "$node"
wait "$node" || true
node=

step "a tool, its page of the manual, the Python module"
robot=$(rospack find proximity_server)/config/demo/robot.urdf
rosrun proximity_server clearance "$robot" --zero --quiet
man proximity_server-clearance | grep -e --assert-above
python3 - "$robot" <<'PYTHON'
import sys
import proximity
robot = proximity.Robot(sys.argv[1])
print(robot.minimum([0.0] * len(robot.joints)))
PYTHON

step "find_package() without catkin"
mkdir "$folder/plain"
cat >"$folder/plain/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.16)
project(plain CXX)
find_package(proximity_server REQUIRED)
add_executable(plain plain.cpp)
target_link_libraries(plain PRIVATE proximity_server::proximity_narrowphase)
CMAKE
cat >"$folder/plain/plain.cpp" <<'CPP'
#include <proximity_server/narrowphase/signed_distance.h>
int main() {
  using namespace proximity_server::narrowphase;
  return signedDistance(Sphere{0.2}, Sphere{0.3}, Eigen::Isometry3d(Eigen::Translation3d(1.0, 0.0, 0.0))).distance > 0.49 ? 0 : 1;
}
CPP
cmake -S "$folder/plain" -B "$folder/plain/build" >/dev/null
cmake --build "$folder/plain/build" >/dev/null
"$folder/plain/build/plain"

step "removed"
dpkg --purge libproximity-server-dev python3-proximity proximity-server proximity-server-msgs libproximity-server >/dev/null
everything >"$folder/after"
diff "$folder/before" "$folder/after" && echo "nothing is left"
