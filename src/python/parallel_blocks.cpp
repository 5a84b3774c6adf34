#include "python/parallel_blocks.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace proximity_server::python {
namespace {

class Blocks {
 public:
  Blocks(Eigen::Index count, Eigen::Index block) : count_(count), block_(block) {}

  /// Never throws.
  void work(const std::function<BlockWork()>& start, const std::function<bool()>& goes_on) {
    try {
      const BlockWork answer = start();
      while (!is_over_ && goes_on()) {
        const Eigen::Index first = next_.fetch_add(block_);
        if (first >= count_) return;
        answer(first, std::min(block_, count_ - first));
      }
      is_over_ = true;
    } catch (...) {
      is_over_ = true;
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
  }

  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  const Eigen::Index count_, block_;
  std::atomic<Eigen::Index> next_{0};
  std::atomic<bool> is_over_{false};
  std::mutex mutex_;
  std::exception_ptr failure_;
};

/// Starts up to `count` threads; fewer if the system has no more of them.
std::vector<std::thread> startThreads(Eigen::Index count, const std::function<void()>& work) {
  std::vector<std::thread> threads;
  threads.reserve(static_cast<std::size_t>(count));
  try {
    while (static_cast<Eigen::Index>(threads.size()) < count) threads.emplace_back(work);
  } catch (const std::system_error&) {
    return threads;
  }
  return threads;
}

}  // namespace

void workInBlocks(Eigen::Index count, Eigen::Index block, int threads, const std::function<BlockWork()>& start,
                  const std::function<bool()>& goes_on) {
  Blocks blocks(count, block);
  const Eigen::Index useful = std::max<Eigen::Index>(1, std::min<Eigen::Index>(threads, (count + block - 1) / block));
  std::vector<std::thread> others = startThreads(useful - 1, [&] { blocks.work(start, [] { return true; }); });
  blocks.work(start, goes_on);
  for (std::thread& thread : others) thread.join();
  blocks.rethrow();
}

}  // namespace proximity_server::python
