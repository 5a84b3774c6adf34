#pragma once

#include "sanitized.h"

#include <malloc.h>

#include <cstddef>

#ifdef PROXIMITY_SANITIZED
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();
#endif

namespace proximity_server {

/// Bytes of the heap that are in use by all threads. glibc before 2.33 counts them up to 4 GB.
inline std::size_t heapInUse() {
#ifdef PROXIMITY_SANITIZED
  return __sanitizer_get_current_allocated_bytes();
#elif __GLIBC_PREREQ(2, 33)
  const auto heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;  // hblkhd: blocks so large that they are mapped by themselves
#else
  const auto heap = mallinfo();
  return static_cast<std::size_t>(static_cast<unsigned>(heap.uordblks)) + static_cast<unsigned>(heap.hblkhd);
#endif
}

}  // namespace proximity_server
