#!/usr/bin/env bash
# Builds the package in workspaces as its users have them, each with two packages that use it: one its libraries and messages, one
# clearancetest.
#
#   workspaces.sh [WAY]...    WAY: catkin_make, catkin_make_isolated, cmake; default: all of them. Without tools, which no way builds otherwise.
set -euo pipefail
source_folder=$(readlink -f "$(dirname "$0")/../..")
[ $# -gt 0 ] || set -- catkin_make catkin_make_isolated cmake
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export HOME=$folder ROS_HOSTNAME=localhost ROS_PACKAGE_PATH=/usr/share

# make_client <name> <dependencies>...: package.xml of a package below $folder/src; its other files come from the caller.
make_client() {
  local name=$1 dependency
  shift
  mkdir -p "$folder/src/$name"
  {
    echo "<package format=\"2\"><name>$name</name><version>1.0.0</version><description>Uses proximity_server.</description>"
    echo "<maintainer email=\"nobody@example.org\">Nobody</maintainer><license>BSD</license><buildtool_depend>catkin</buildtool_depend>"
    for dependency; do echo "<depend>$dependency</depend>"; done
    echo "</package>"
  } >"$folder/src/$name/package.xml"
}

make_client uses_library roscpp proximity_server
cat >"$folder/src/uses_library/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.16)
project(uses_library CXX)
find_package(catkin QUIET COMPONENTS roscpp)
find_package(proximity_server REQUIRED)
add_executable(answer answer.cpp)
target_link_libraries(answer PRIVATE proximity_server::proximity_scene)
if(catkin_FOUND)
  catkin_package()
  target_include_directories(answer PRIVATE ${catkin_INCLUDE_DIRS} ${proximity_server_INCLUDE_DIRS})
  target_compile_definitions(answer PRIVATE WITH_MESSAGES)
  install(TARGETS answer RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endif()
CMAKE
cat >"$folder/src/uses_library/answer.cpp" <<'CPP'
#include <proximity_server/scene/loading/load_robot_model.h>

#include <iostream>
#ifdef WITH_MESSAGES
#include <proximity_server/MinimumDistance.h>
#endif
int main() {
  using namespace proximity_server::scene;
  std::cout << loadRobotModel("<robot name='r'><link name='base'/></robot>", packageResolver({})).robot.links.size() << " link\n";
#ifdef WITH_MESSAGES
  std::cout << ros::service_traits::datatype<proximity_server::MinimumDistance>() << "\n";
#endif
}
CPP

make_client uses_clearancetest proximity_server rostest
cat >"$folder/src/uses_clearancetest/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.16)
project(uses_clearancetest NONE)
find_package(catkin REQUIRED)
catkin_package()
if(CATKIN_ENABLE_TESTING)
  find_package(rostest REQUIRED)
  add_rostest(keeps_clear.test)
endif()
CMAKE
# shellcheck disable=SC2016  # a fence of Markdown
sed -n '/^```xml/,/^```/p' "$source_folder/test/node/clearancetest/README.md" | sed '/^```/d' >"$folder/src/uses_clearancetest/keeps_clear.test"

# check_client <command>: what uses_library prints.
check_client() {
  local said
  said=$("$@")
  echo "$said"
  [[ "$said" == "1 link"* ]]
}

# with_setup <folder of setup.bash> <command>
with_setup() (
  set +u
  # shellcheck source=/dev/null
  source "$1/setup.bash"
  set -u
  "${@:2}"
)

for way; do
  echo "--- $way"
  case "$way" in
    catkin_make)
      ln -s "$source_folder" "$folder/src/proximity_server"
      (cd "$folder" && catkin_make -DCMAKE_BUILD_TYPE=Release -DPROXIMITY_TOOLS=OFF "-j$(nproc)" &&
        catkin_make -DPROXIMITY_TOOLS=OFF run_tests_uses_clearancetest)
      with_setup "$folder/devel" catkin_test_results "$folder/build/test_results"
      with_setup "$folder/devel" check_client rosrun uses_library answer
      ;;
    catkin_make_isolated)
      [ -e "$folder/src/proximity_server" ] || ln -s "$source_folder" "$folder/src/proximity_server"
      (cd "$folder" && catkin_make_isolated --install --cmake-args -DCMAKE_BUILD_TYPE=Release -DPROXIMITY_TOOLS=OFF -DCATKIN_ENABLE_TESTING=ON)
      with_setup "$folder/install_isolated" check_client rosrun uses_library answer
      with_setup "$folder/install_isolated" rostest "$folder/src/uses_clearancetest/keeps_clear.test"
      ;;
    cmake)
      cmake -S "$source_folder" -B "$folder/plain" -DCMAKE_BUILD_TYPE=Release -DCMAKE_DISABLE_FIND_PACKAGE_catkin=ON -DPROXIMITY_TOOLS=OFF \
        "-DCMAKE_INSTALL_PREFIX=$folder/prefix"
      cmake --build "$folder/plain" "-j$(nproc)"
      cmake --install "$folder/plain"
      cmake -S "$folder/src/uses_library" -B "$folder/client" -DCMAKE_DISABLE_FIND_PACKAGE_catkin=ON "-DCMAKE_PREFIX_PATH=$folder/prefix"
      cmake --build "$folder/client"
      check_client "$folder/client/answer"
      ;;
    *) echo "workspaces.sh: no way is called $way" >&2; exit 2 ;;
  esac
done
