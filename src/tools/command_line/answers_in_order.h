#pragma once

#include <deque>
#include <functional>
#include <future>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace proximity_server::tools {

/// Runs jobs in several threads and handles their answers in the order in which the jobs were started, in the calling
/// thread. At most `threads` jobs run or wait to be handled.
/// Failure: start() and finish() throw what a job throws. start() throws std::runtime_error if no thread can be
///          started.
template <typename Answer>
class AnswersInOrder {
 public:
  AnswersInOrder(int threads, std::function<void(Answer)> handle)
      : threads_(static_cast<std::size_t>(threads)), handle_(std::move(handle)) {}

  void start(std::function<Answer()> work) {
    if (running_.size() == threads_) handleOldest();
    try {
      running_.push_back(std::async(std::launch::async, std::move(work)));
    } catch (const std::system_error& error) {
      throw std::runtime_error("only " + std::to_string(running_.size()) + " of " + std::to_string(threads_) +
                               " threads could be started (" + error.code().message() +
                               "); ask for fewer with --threads");
    }
  }

  void finish() {
    while (!running_.empty()) handleOldest();
  }

 private:
  void handleOldest() {
    handle_(running_.front().get());
    running_.pop_front();
  }

  std::size_t threads_;
  std::function<void(Answer)> handle_;
  std::deque<std::future<Answer>> running_;
};

}  // namespace proximity_server::tools
