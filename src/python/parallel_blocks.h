#pragma once

#include <Eigen/Core>
#include <functional>

namespace proximity_server::python {

/// Answers the items first, first + 1, ... of a block.
using BlockWork = std::function<void(Eigen::Index first, Eigen::Index count)>;

/// The usual size of a block: so many that its beginning does not count, and so few that many threads have work.
constexpr Eigen::Index kBlock = 256;

/// Divides `count` items into blocks of this size, which up to `threads` threads take one after the other; the caller's is one of them, and
/// there are fewer where the system has no more. Each of these calls `start` once and gives its blocks to what that returns.
/// The caller's calls `goes_on` before each of its blocks, and where that is false no more are begun.
/// Failure: throws the first exception of a thread, once all have ended; no more blocks are begun then.
void workInBlocks(Eigen::Index count, Eigen::Index block, int threads, const std::function<BlockWork()>& start,
                  const std::function<bool()>& goes_on);

}  // namespace proximity_server::python
