#pragma once

#include <functional>
#include <string>

namespace proximity_server::scene {

/// Calls `work(i, tell)` for i = 0, 1, ... count - 1 in up to `threads` threads (0: as many as there are cores),
/// started in this order. A text that any of them passes to `tell` is passed on to `told(i, text)` by the calling
/// thread, one at a time. Returns when all work is done.
/// Failure: `work` must not throw. If `told` throws, no more work is started, and the exception is thrown from here.
void workInParallel(int count, int threads,
                    const std::function<void(int, const std::function<void(const std::string&)>&)>& work,
                    const std::function<void(int, const std::string&)>& told);

}  // namespace proximity_server::scene
