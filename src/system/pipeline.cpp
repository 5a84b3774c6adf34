#include "system/pipeline.h"

#include <algorithm>
#include <condition_variable>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

namespace proximity_server::system {
namespace {

class Pipeline {
 public:
  Pipeline(const PipelineSteps<const std::size_t>& steps, std::size_t blocks, const PipelineThreads& threads)
      : steps_(steps), threads_(threads), most_(static_cast<std::size_t>(threads.count)) {
    others_.reserve(most_);
    for (std::size_t i = blocks; i > 0; --i) free_.push_back(i - 1);
  }

  void run() {
    work(0);
    // A thread starts others before it ends itself. So no thread is added once all known threads have ended.
    for (std::size_t i = 0; std::thread* other = otherThread(i); ++i) other->join();
    if (error_) std::rethrow_exception(error_);
  }

 private:
  struct Numbered {
    std::size_t number;  ///< in the order of reading
    std::size_t block;
  };

  void work(int thread) {
    while (const std::optional<Numbered> next = nextBlock()) {
      try {
        startAnother();
        steps_.work(next->block, thread);
        writeInTurn(*next);
      } catch (...) {
        keep(next->number, std::current_exception());  // its turn to be written never comes
      }
    }
  }

  /// Reads the next block. Returns nullopt at the end, and after an error.
  std::optional<Numbered> nextBlock() {
    const std::lock_guard reading(read_mutex_);
    const std::optional<std::size_t> block = freeBlock();
    if (!block) return std::nullopt;
    try {
      if (steps_.read(*block)) return Numbered{read_count_++, *block};
      const std::lock_guard lock(mutex_);
      is_read_ = true;
    } catch (...) {
      keep(read_count_, std::current_exception());
    }
    return std::nullopt;
  }

  /// Waits until a block is free. Returns nullopt if no more blocks are needed.
  std::optional<std::size_t> freeBlock() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return is_read_ || !free_.empty(); });
    if (is_read_) return std::nullopt;
    const std::size_t block = free_.back();
    free_.pop_back();
    return block;
  }

  /// Writes the blocks whose turn has come, unless another thread is writing: that thread checks again after each
  /// block.
  void writeInTurn(const Numbered& next) {
    std::unique_lock lock(mutex_);
    if (!steps_.write) return setFree(next.block);
    worked_.emplace(next.number, next.block);
    if (is_writing_) return;
    is_writing_ = true;
    while (!worked_.empty() && worked_.begin()->first == written_count_) {
      const std::size_t block = worked_.begin()->second;
      worked_.erase(worked_.begin());
      lock.unlock();
      try {
        steps_.write(block);
      } catch (...) {
        keep(written_count_, std::current_exception());
        return;  // is_writing_ stays true, so that no other thread writes
      }
      lock.lock();
      ++written_count_;
      setFree(block);
    }
    is_writing_ = false;
  }

  /// mutex_ must be locked.
  void setFree(std::size_t block) {
    free_.push_back(block);
    changed_.notify_one();  // only the thread that reads waits
  }

  void startAnother() {
    const std::lock_guard lock(mutex_);
    const std::size_t running = others_.size() + 1;
    if (is_read_ || running >= most_) return;
    try {
      others_.emplace_back([this, running] { work(static_cast<int>(running)); });
    } catch (const std::system_error& error) {
      most_ = running;
      if (threads_.too_few == PipelineThreads::TooFew::Enough) return;
      keepLocked(0, std::make_exception_ptr(std::runtime_error(
                        "only " + std::to_string(running) + " of " + std::to_string(threads_.count) +
                        " threads could be started (" + error.code().message() + "); ask for fewer with --threads")));
    }
  }

  /// nullptr if there are fewer threads.
  std::thread* otherThread(std::size_t i) {
    const std::lock_guard lock(mutex_);
    return i < others_.size() ? &others_[i] : nullptr;
  }

  void keep(std::size_t number, std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    keepLocked(number, std::move(error));
  }
  void keepLocked(std::size_t number, std::exception_ptr error) {
    if (number < failed_) error_ = std::move(error);
    failed_ = std::min(failed_, number);
    is_read_ = true;
    changed_.notify_one();
  }

  const PipelineSteps<const std::size_t>& steps_;
  const PipelineThreads threads_;

  std::mutex read_mutex_;  ///< for `read` and read_count_; locked before mutex_
  std::size_t read_count_ = 0;

  std::mutex mutex_;  ///< for all members below
  std::condition_variable changed_;
  std::size_t most_;                           ///< the largest number of threads
  std::vector<std::thread> others_;            ///< reserved, so that its elements never move
  bool is_read_ = false;                       ///< no more blocks are needed, or there are none
  std::vector<std::size_t> free_;              ///< free blocks
  std::map<std::size_t, std::size_t> worked_;  ///< blocks that wait to be written, by number
  std::size_t written_count_ = 0;
  bool is_writing_ = false;
  std::size_t failed_ = std::numeric_limits<std::size_t>::max();  ///< the number of the first block that has failed
  std::exception_ptr error_;                                      ///< the error of that block
};

}  // namespace

void runPipeline(const PipelineSteps<const std::size_t>& steps, std::size_t blocks, const PipelineThreads& threads) {
  Pipeline(steps, blocks, threads).run();
}

}  // namespace proximity_server::system
