#pragma once

#include "proximity_server/scene/objects/objects.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

namespace proximity_server::node {

/// The objects around a robot, with the revision that ~objects gives them.
struct RobotObjects {
  std::shared_ptr<const scene::Objects> all;
  std::uint64_t revision = 0;
};

/// Holds the objects that requests and the monitor use now. A request takes them once, and keeps them until it is
/// answered. Thread-safe.
class ObjectSlot {
 public:
  explicit ObjectSlot(RobotObjects objects) : objects_(std::move(objects)) {}

  RobotObjects get() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return objects_;
  }
  void set(RobotObjects objects) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::swap(objects_, objects);  // the previous objects are destroyed after the lock is released
  }

 private:
  mutable std::mutex mutex_;
  RobotObjects objects_;
};

}  // namespace proximity_server::node
