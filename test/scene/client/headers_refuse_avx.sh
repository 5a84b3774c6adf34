#!/bin/sh
# headers_refuse_avx.sh COMPILER INCLUDE_FOLDER
# Compiles each public header as a client with AVX would who does not link our CMake target. Every header through which
# Eigen comes in must refuse, with the reason.
compiler=$1
cd "$2" || exit 1
accepted="" refused=0
for header in $(find . -name '*.h' | sort); do
  compile="$compiler -std=c++17 -mavx -I. -I/usr/include/eigen3 -x c++ -include $header /dev/null"
  if $compile -fsyntax-only -Wfatal-errors 2>&1 | grep -q 'define EIGEN_MAX_STATIC_ALIGN_BYTES=16'; then
    refused=$((refused + 1))
  elif $compile -M | grep -q /Eigen/; then
    accepted="$accepted $header"
  fi
done
echo "$refused headers refuse another layout"
[ -z "$accepted" ] || { echo "these do not, they should include eigen_alignment.h:$accepted"; exit 1; }
[ "$refused" -gt 10 ]
