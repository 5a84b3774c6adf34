#pragma once

#include <boost/shared_ptr.hpp>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "node/objects/object_store.h"
#include "proximity_server/ObjectChanges.h"

namespace proximity_server::node {

/// Applies the changes that come by topic, in their order, in a thread of its own.
///
/// 1. take() puts a message behind those that wait, or refuses it if they are too many. It never waits.
/// 2. The thread applies all that wait in one change, because a change costs the more the more objects there are: so it
///    keeps up with any number of messages. A message with meshes, which may take seconds, is applied alone.
class ChangeStream {
 public:
  /// What may wait: a message that would make it more is refused. A single one may be larger.
  static constexpr std::size_t kMostMessages = 10000;
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;

  using Messages = std::vector<boost::shared_ptr<const ObjectChanges>>;

  /// `refused` gets the reason for each message that is left out. The store must outlive this.
  ChangeStream(ObjectStore& store, std::function<void(const std::string& reason)> refused);

  /// Leaves out what still waits.
  ~ChangeStream();

  void take(const boost::shared_ptr<const ObjectChanges>& message);

 private:
  struct Waiting {
    boost::shared_ptr<const ObjectChanges> message;
    std::size_t bytes;
  };

  void run();
  Messages next();

  ObjectStore& store_;
  const std::function<void(const std::string&)> refused_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  bool ends_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace proximity_server::node
