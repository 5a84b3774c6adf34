#pragma once

#include <Eigen/Core>

// Refuses to compile if public types would have a layout that differs from that in the library.
//
// Public types hold Eigen types by value. Eigen aligns these to what the compiler may assume of the processor: an
// Isometry3d to 16 bytes in general, to 32 with -mavx, to 64 with AVX-512 (-march=native means any of them). Such a
// program and the library would look for the members of one struct at different addresses. Therefore the library uses
// 16 bytes on every processor, and so must all programs that include its headers. The CMake target
// proximity_server::proximity_narrowphase sets this for every program that links it. A program that is compiled without
// the target, and with such options, must define EIGEN_MAX_STATIC_ALIGN_BYTES=16 as a whole; vector instructions are
// used all the same. The target also sets -ffp-contract=off: without it, if the compiler may fuse products with sums
// (-mfma, -march=native, ARM), the inline functions of our headers give other bits than the library. No header can
// check that.

static_assert(EIGEN_MAX_STATIC_ALIGN_BYTES == 16,
              "the library of proximity_server is built with EIGEN_MAX_STATIC_ALIGN_BYTES=16, but the options of this "
              "unit (such as -mavx or -march=native) give Eigen's types another alignment: link the CMake target "
              "proximity_server::proximity_narrowphase, or define EIGEN_MAX_STATIC_ALIGN_BYTES=16");
