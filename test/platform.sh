#!/usr/bin/env bash
# Another Debian in a folder, with the packages that package.xml names and a build of its own: ./dev platform.
#
#   platform.sh NAME [COMMAND...]    NAME: bullseye, bookworm or trixie. Runs the command there, "./dev test" if there is none, as root
#                                    in this folder. It sees the repository read-only, with a folder build/ of that system.
#
# PROXIMITY_PLATFORMS names another folder than build/platform for the systems. Each takes some GB, and stays there.
set -euo pipefail
# No other process sees the folders that are mounted below. They are unmounted when the last of these processes ends.
if [ "${1:-}" != --alone ]; then exec unshare --mount --propagation private "$0" --alone "$@"; fi
shift
cd "$(dirname "$(readlink -f "$0")")/.."
name=${1:-}
[ $# = 0 ] || shift
[ $# -gt 0 ] || set -- ./dev test

compiler=g++
case "$name" in
  bullseye) compiler=g++-9 ;;  # that of Ubuntu 20.04, the next relative of this Debian
  bookworm | trixie) ;;
  *) echo "platform.sh: which one? bullseye, bookworm or trixie, not '$name'" >&2; exit 2 ;;
esac
folder=$(realpath -m -- "${PROXIMITY_PLATFORMS:-build/platform}/$name")
system=$folder/system

# Makes the system. It gets its name when it is complete.
if [ ! -d "$system" ]; then
  command -v mmdebstrap >/dev/null || apt-get -q -y install --no-install-recommends mmdebstrap
  mirror=$(cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null | grep -v '^#' | grep -oE -m 1 'https?://[^ ]*/debian/?( |$)' || true)
  rm -rf "$system.part"
  mkdir -p "$folder"
  mmdebstrap --variant=minbase --dpkgopt=force-unsafe-io --include="$compiler,ca-certificates,git" "$name" "$system.part" "${mirror:-http://deb.debian.org/debian}"
  git config --file "$system.part/etc/gitconfig" safe.directory '*'  # the repository may belong to somebody else than root
  mv "$system.part" "$system"
fi

repo=$PWD
mkdir -p build "$folder/build" "$system$repo"
for kernel in /proc /sys /dev; do mount --rbind "$kernel" "$system$kernel"; done
mount --bind "$repo" "$system$repo"
mount --bind "$folder/build" "$system$repo/build"
mount -o remount,bind,ro "$system$repo"
if [ -d ../shared/robots ]; then  # where ./dev finds robots
  mkdir -p "$system$(realpath ../shared)"
  mount --bind ../shared "$system$(realpath ../shared)"
  mount -o remount,bind,ro "$system$(realpath ../shared)"
fi
cp -L /etc/resolv.conf /etc/hosts "$system/etc/"
exec env -i HOME=/root LANG=C.UTF-8 PATH=/usr/bin:/bin:/usr/sbin:/sbin "TERM=${TERM:-dumb}" "CXX=$compiler" \
  chroot "$system" env --chdir="$repo" "$@"
