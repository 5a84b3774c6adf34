#pragma once

#include <functional>
#include <string>

namespace proximity_server::scene {

/// Does `work(i, tell)` for i = 0, 1, ... count - 1 in up to `threads` threads (0: as many as there are cores), begun
/// in this order. What is told to `tell` in any of them is passed to `told(i, text)` by the calling thread, one at a
/// time. Returns when all is done. `work` must not throw; where `told` does, no more work is begun and this throws it
/// too.
void workInParallel(int count, int threads,
                    const std::function<void(int, const std::function<void(const std::string&)>&)>& work,
                    const std::function<void(int, const std::string&)>& told);

}  // namespace proximity_server::scene
