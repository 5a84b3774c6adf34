#pragma once

#include <deque>
#include <functional>
#include <future>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace proximity_server::tools {

/// Runs work in several threads and hands on the answers in the order in which the work came, in the calling thread.
/// At most `threads` answers wait. What the work throws comes out of start() or finish().
/// Failure: start() throws std::runtime_error where the system has no further thread.
template <typename Answer>
class AnswersInOrder {
 public:
  AnswersInOrder(int threads, std::function<void(Answer)> take)
      : threads_(static_cast<std::size_t>(threads)), take_(std::move(take)) {}

  void start(std::function<Answer()> work) {
    if (running_.size() == threads_) takeOldest();
    try {
      running_.push_back(std::async(std::launch::async, std::move(work)));
    } catch (const std::system_error& error) {
      throw std::runtime_error("only " + std::to_string(running_.size()) + " of " + std::to_string(threads_) +
                               " threads could be started (" + error.code().message() +
                               "); ask for fewer with --threads");
    }
  }

  void finish() {
    while (!running_.empty()) takeOldest();
  }

 private:
  void takeOldest() {
    take_(running_.front().get());
    running_.pop_front();
  }

  std::size_t threads_;
  std::function<void(Answer)> take_;
  std::deque<std::future<Answer>> running_;
};

}  // namespace proximity_server::tools
