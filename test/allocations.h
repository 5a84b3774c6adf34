#pragma once

#include <cstddef>

namespace proximity_server {

/// How many times the calling thread took memory from the heap so far. Whoever links this replaces the C library's
/// malloc; where a sanitizer has one of its own, it is that one which counts.
long allocations();

/// Bytes of the heap that are in use by all threads.
std::size_t heapInUse();

}  // namespace proximity_server
