#pragma once

#include "node/objects/object_store.h"
#include "proximity_server/ObjectChanges.h"

#include <boost/shared_ptr.hpp>

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace proximity_server::node {

/// Applies the changes that come by topic, in the order of their arrival, in a thread of its own.
///
/// 1. enqueue() adds a message to the queue, or refuses it if the queue is full. It never waits.
/// 2. The thread applies all messages of the queue in one change, because a change takes the longer the more objects
///    there are. So it keeps up with any number of messages. A message with meshes, which may take seconds, is applied
///    alone.
class ChangeStream {
 public:
  /// Limits of the queue. A message that would exceed them is refused, unless the queue is empty.
  static constexpr std::size_t kMaxMessages = 10000;
  static constexpr std::size_t kMaxBytes = std::size_t{64} << 20;

  using Messages = std::vector<boost::shared_ptr<const ObjectChanges>>;

  /// `refused` is called with the reason for each message that is refused. The store must outlive this object.
  ChangeStream(ObjectStore& store, std::function<void(const std::string& reason)> refused);

  /// Drops the messages that are still in the queue.
  ~ChangeStream();

  void enqueue(const boost::shared_ptr<const ObjectChanges>& message);

 private:
  struct QueuedMessage {
    boost::shared_ptr<const ObjectChanges> message;
    std::size_t bytes;
  };

  void run();
  Messages next();

  ObjectStore& store_;
  const std::function<void(const std::string&)> refused_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::deque<QueuedMessage> waiting_;
  std::size_t waiting_bytes_ = 0;
  bool is_stopping_ = false;
  std::thread thread_;  // the last member, because the thread uses all others
};

}  // namespace proximity_server::node
