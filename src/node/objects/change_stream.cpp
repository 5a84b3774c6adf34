#include "node/objects/change_stream.h"

#include "system/number_text.h"

#include <ros/console.h>
#include <ros/serialization.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace proximity_server::node {
namespace {

using UniqueLock = std::unique_lock<std::mutex>;

bool hasMesh(const ObjectChanges& message) {
  return std::any_of(message.changes.begin(), message.changes.end(),
                     [](const ObjectChange& change) { return !change.meshes.empty() || !change.mesh_files.empty(); });
}

}  // namespace

ChangeStream::ChangeStream(ObjectStore& store, std::function<void(const std::string&)> refused)
    : store_(store), refused_(std::move(refused)), thread_([this] { run(); }) {}

ChangeStream::~ChangeStream() {
  {
    const UniqueLock lock(mutex_);
    is_stopping_ = true;
    waiting_.clear();
  }
  changed_.notify_all();
  thread_.join();
}

void ChangeStream::enqueue(const boost::shared_ptr<const ObjectChanges>& message) {
  const std::size_t bytes = ros::serialization::serializationLength(*message);
  {
    const UniqueLock lock(mutex_);
    const bool fits = waiting_.size() < kMaxMessages && waiting_bytes_ + bytes <= kMaxBytes;
    if (fits || waiting_.empty()) {
      waiting_.push_back({message, bytes});
      waiting_bytes_ += bytes;
      changed_.notify_one();
      return;
    }
  }
  refused_(
      "too many changes wait, so that this message is left out: call the service, which answers when it has applied "
      "them");
}

void ChangeStream::run() {
  while (true) {
    const Messages messages = next();
    if (messages.empty()) return;
    std::vector<const ObjectChanges*> together;
    for (const auto& message : messages) together.push_back(message.get());
    try {
      store_.applyTogether(
          together, [this](const std::exception& error) { refused_(error.what()); },
          [](const std::string& remark) {
            ROS_INFO_STREAM_THROTTLE(1.0, "~apply_objects: " << system::readable(remark));
          });
    } catch (const std::exception& error) {
      refused_(std::string("internal error: ") + error.what());
    }
  }
}

/// Waits for messages, and takes those from the queue that can be applied together. Returns none if the thread has to
/// end.
ChangeStream::Messages ChangeStream::next() {
  UniqueLock lock(mutex_);
  changed_.wait(lock, [this] { return is_stopping_ || !waiting_.empty(); });
  Messages messages;
  while (!waiting_.empty()) {
    const bool alone = hasMesh(*waiting_.front().message);
    if (alone && !messages.empty()) break;
    messages.push_back(std::move(waiting_.front().message));
    waiting_bytes_ -= waiting_.front().bytes;
    waiting_.pop_front();
    if (alone) break;
  }
  return messages;
}

}  // namespace proximity_server::node
