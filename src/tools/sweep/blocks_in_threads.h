#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace proximity_server::tools {

/// What happens to each block of a sequence.
template <typename Block>
struct BlockSteps {
  std::function<bool(Block&)> read;                ///< fills the next block; false at the end. One call at a time
  std::function<void(Block&, int thread)> answer;  ///< threads are numbered from 0; several calls at a time
  std::function<void(Block&)> write;               ///< gets the blocks in their order. One call at a time
};

/// Reads, answers and writes a sequence of blocks in several threads, which keep what they need from one block to the
/// next: each reads the next block, answers it, and then writes all blocks whose turn has come. Blocks are used again,
/// so that their memory is allocated once.
template <typename Block>
class BlocksInThreads {
 public:
  BlocksInThreads(BlockSteps<Block> steps, int threads) : steps_(std::move(steps)), threads_(threads) {}

  /// Failure: throws the first error of a step; if it is one of reading, after the blocks before it were written. Throws
  ///          std::runtime_error if a thread cannot be started.
  void run() {
    std::vector<std::thread> others;
    try {
      others.reserve(static_cast<std::size_t>(threads_));
      for (int i = 1; i < threads_; ++i) others.emplace_back([this, i] { work(i); });
    } catch (const std::system_error& error) {
      stop(std::make_exception_ptr(std::runtime_error("only " + std::to_string(others.size() + 1) + " of " +
                                                      std::to_string(threads_) + " threads could be started (" +
                                                      error.code().message() + "); ask for fewer with --threads")));
    }
    work(0);
    for (std::thread& other : others) other.join();
    if (error_) std::rethrow_exception(error_);
  }

 private:
  /// Blocks that are read but not written, for each thread: so many that a slow one does not stop the others.
  static constexpr std::uint64_t kAhead = 4;

  struct Numbered {
    std::uint64_t number = 0;
    Block* block = nullptr;
  };

  void work(int thread) {
    try {
      for (Numbered next = nextBlock(); next.block; next = nextBlock()) {
        steps_.answer(*next.block, thread);
        writeInTurn(next);
      }
    } catch (...) {
      stop(std::current_exception());
    }
  }

  /// Without a block at the end, and after an error.
  Numbered nextBlock() {
    const std::lock_guard reading(read_mutex_);
    if (is_read_) return {};
    Block* block = freeBlock();
    if (!block) return {};
    try {
      is_read_ = !steps_.read(*block);
    } catch (...) {
      is_read_ = true;
      keep(std::current_exception());
    }
    if (is_read_) return {};
    const std::lock_guard lock(mutex_);
    return {next_read_++, block};
  }

  /// Waits until enough blocks are written; nullptr after an error.
  Block* freeBlock() {
    std::unique_lock lock(mutex_);
    const std::uint64_t most = kAhead * static_cast<std::uint64_t>(threads_);
    changed_.wait(lock, [&] { return is_stopped_ || next_read_ - next_write_ < most; });
    if (is_stopped_) return nullptr;
    if (free_.empty()) {
      blocks_.push_back(std::make_unique<Block>());
      return blocks_.back().get();
    }
    Block* block = free_.back();
    free_.pop_back();
    return block;
  }

  /// Writes the blocks whose turn has come, unless another thread is at it: that one looks again after each.
  void writeInTurn(const Numbered& answered) {
    std::unique_lock lock(mutex_);
    answered_.emplace(answered.number, answered.block);
    if (is_writing_) return;
    is_writing_ = true;
    while (!is_stopped_ && !answered_.empty() && answered_.begin()->first == next_write_) {
      Block* block = answered_.begin()->second;
      answered_.erase(answered_.begin());
      lock.unlock();
      steps_.write(*block);
      lock.lock();
      free_.push_back(block);
      ++next_write_;
      changed_.notify_all();
    }
    is_writing_ = false;
  }

  void keep(std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
  }

  void stop(std::exception_ptr error) {
    keep(std::move(error));
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
    changed_.notify_all();
  }

  BlockSteps<Block> steps_;
  int threads_;

  std::mutex read_mutex_;  ///< for `read` and is_read_; locked before mutex_
  bool is_read_ = false;   ///< all of the sequence, or up to an error

  std::mutex mutex_;  ///< for all that follows
  std::condition_variable changed_;
  std::vector<std::unique_ptr<Block>> blocks_;
  std::vector<Block*> free_;
  std::map<std::uint64_t, Block*> answered_;  ///< that wait for their turn
  std::uint64_t next_read_ = 0, next_write_ = 0;
  bool is_writing_ = false, is_stopped_ = false;
  std::exception_ptr error_;
};

}  // namespace proximity_server::tools
