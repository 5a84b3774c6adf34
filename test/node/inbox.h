#pragma once

#include "node/patience.h"

#include <ros/node_handle.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace proximity_server::node {

/// The messages of a topic, for tests that wait for one. Needs a spinning thread.
template <class Message>
class Inbox {
 public:
  Inbox(ros::NodeHandle nh, const std::string& topic)
      : subscriber_(nh.subscribe<Message>(topic, 1000, [this](const boost::shared_ptr<const Message>& message) {
          const std::lock_guard<std::mutex> lock(mutex_);
          messages_.push_back(*message);
          arrived_.notify_all();
        })) {}

  /// The next message that `accept` likes; every message is offered once. Nothing if none comes in time.
  template <class Accept>
  std::optional<Message> next(Accept accept) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    std::unique_lock<std::mutex> lock(mutex_);
    while (arrived_.wait_until(lock, deadline, [this] { return !messages_.empty(); })) {
      const Message message = messages_.front();
      messages_.pop_front();
      if (accept(message)) return message;
    }
    return std::nullopt;
  }
  std::optional<Message> next() {
    return next([](const Message&) { return true; });
  }

  /// Forgets what came so far and says how much that was.
  std::size_t clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::size_t count = messages_.size();
    messages_.clear();
    return count;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<Message> messages_;
  ros::Subscriber subscriber_;
};

}  // namespace proximity_server::node
