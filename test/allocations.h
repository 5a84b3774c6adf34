#pragma once

namespace proximity_server {

/// How many times the calling thread took memory from the heap so far. Whoever links this replaces the C library's
/// malloc; where a sanitizer has one of its own, it is that one which counts.
long allocations();

}  // namespace proximity_server
