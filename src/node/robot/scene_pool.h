#pragma once

#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/motion/spline_scene.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/uncertainty/guaranteed_distances.h"

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace proximity_server::node {

/// Lends scratch objects to requests that run in parallel, and makes a new one if all are lent. Thread-safe.
///
/// A lease returns its object to the pool when it is destroyed; the pool must outlive it.
template <class Scratch>
class Pool {
 public:
  explicit Pool(std::function<Scratch()> make) : make_(std::move(make)) {}

  using Lease = std::unique_ptr<Scratch, std::function<void(Scratch*)>>;

  Lease borrow() {
    return Lease(idleOrNew().release(), [this](Scratch* scratch) {
      const std::lock_guard<std::mutex> lock(mutex_);
      idle_.emplace_back(scratch);
    });
  }

 private:
  std::unique_ptr<Scratch> idleOrNew() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<Scratch> scratch = std::move(idle_.back());
        idle_.pop_back();
        return scratch;
      }
    }
    return std::make_unique<Scratch>(make_());
  }

  const std::function<Scratch()> make_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> idle_;
};

using ScenePool = Pool<scene::Scene>;
using MovingScenePool = Pool<scene::MovingScene>;
using GuaranteedPool = Pool<scene::GuaranteedDistances>;
using SplineScenePool = Pool<scene::SplineScene>;

}  // namespace proximity_server::node
