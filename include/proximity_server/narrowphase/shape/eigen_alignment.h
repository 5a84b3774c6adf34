#pragma once

#include <Eigen/Core>

// Refuses to compile where public types would have another layout than in the library.
//
// Public types hold Eigen types by value, and Eigen aligns these to what the compiler may assume of the processor: an
// Isometry3d to 16 bytes in general, to 32 with -mavx, to 64 with AVX-512 (-march=native means any of them). Such a
// program and the library would look for the members of one struct at different places. Therefore the library keeps to
// 16 bytes on every processor, and so must all who include its headers. The CMake target
// proximity_server::proximity_narrowphase sees to that for everybody who links it. Who compiles without it, and with
// such options, defines EIGEN_MAX_STATIC_ALIGN_BYTES=16 for the whole program; vector instructions stay in use.
// The target also sets -ffp-contract=off: without it the inline functions of our headers give other bits than the
// library where the compiler may fuse products with sums (-mfma, -march=native, ARM). No header can check that.

static_assert(EIGEN_MAX_STATIC_ALIGN_BYTES == 16,
              "the library of proximity_server is built with EIGEN_MAX_STATIC_ALIGN_BYTES=16, but the options of this "
              "unit (such as -mavx or -march=native) give Eigen's types another alignment: link the CMake target "
              "proximity_server::proximity_narrowphase, or define EIGEN_MAX_STATIC_ALIGN_BYTES=16");
