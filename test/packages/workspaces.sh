#!/usr/bin/env bash
# Builds the package with the tools of catkin, in one workspace with the package of the newcomer, which uses its libraries, its
# messages and clearancetest; then runs the test of that package. ../readme/newcomer has the other ways.
#
#   workspaces.sh [catkin_make | catkin_make_isolated]...    default: both. Without tools, which are built in no other way.
set -euo pipefail
package=$(readlink -f "$(dirname "$0")/../..")
[ $# -gt 0 ] || set -- catkin_make catkin_make_isolated
options=(-DCMAKE_BUILD_TYPE=Release -DPROXIMITY_TOOLS=OFF)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export HOME=$folder ROS_HOSTNAME=localhost ROS_PACKAGE_PATH=/usr/share

# run_test <folder of setup.bash>
run_test() (
  set +u
  # shellcheck source=/dev/null
  source "$1/setup.bash"
  set -u
  ROS_PACKAGE_PATH+=:/usr/share
  rostest src/client/test/keeps_clear.test
)

for way; do
  echo "--- $way"
  workspace=$folder/$way
  mkdir -p "$workspace/src"
  ln -s "$package" "$workspace/src/proximity_server"
  cp -r "$package/test/readme/newcomer/client" "$workspace/src"
  cd "$workspace"
  case "$way" in
    catkin_make) catkin_make "${options[@]}" && run_test devel ;;
    catkin_make_isolated) catkin_make_isolated --install --cmake-args "${options[@]}" && run_test install_isolated ;;
    *) echo "workspaces.sh: there is no way $way" >&2; exit 2 ;;
  esac
done
