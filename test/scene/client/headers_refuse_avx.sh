#!/bin/sh
# headers_refuse_avx.sh COMPILER INCLUDE_FOLDER
# Compiles as a client with AVX would who does not link our CMake target: eigen_alignment.h must refuse, with the reason,
# and every public header through which Eigen comes in must include it.
compiler="$1 -std=c++17 -mavx -I. -I/usr/include/eigen3 -x c++"
cd "$2" || exit 1
guard=proximity_server/narrowphase/shape/eigen_alignment.h
$compiler -fsyntax-only -include $guard /dev/null 2>&1 | grep -q 'define EIGEN_MAX_STATIC_ALIGN_BYTES=16' ||
  { echo "$guard does not refuse"; exit 1; }
unguarded="" guarded=0
for header in $(find . -name '*.h' | sort); do
  included=$($compiler -M "$header") || exit 1
  case $included in
    */Eigen/*) ;;
    *) continue ;;
  esac
  case $included in
    *"$guard"*) guarded=$((guarded + 1)) ;;
    *) unguarded="$unguarded $header" ;;
  esac
done
echo "$guarded headers refuse another layout"
[ -z "$unguarded" ] || { echo "these do not, they should include eigen_alignment.h:$unguarded"; exit 1; }
[ "$guarded" -gt 10 ]
