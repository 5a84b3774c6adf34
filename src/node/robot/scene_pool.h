#pragma once

#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/state/state.h"

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace proximity_server::node {

/// A state of a robot with what answers questions about it and about motions from it, for one request or the monitor.
/// Not thread-safe.
struct PosedScenes {
  PosedScenes(const scene::State& shared, const scene::Scene& fresh)
      : state(shared.forAnotherThread()), scene(fresh.forAnotherThread()) {}

  // The others are made when they are first needed. The search of motions has the objects of the state.
  scene::GuaranteedDistances& guaranteed() {
    if (!guaranteed_) guaranteed_.emplace(state.sharedModel());
    return *guaranteed_;
  }
  scene::PointSearch& points() { return points_ ? *points_ : points_.emplace(state.sharedModel()); }
  scene::RaySearch& rays() { return rays_ ? *rays_ : rays_.emplace(state.sharedModel()); }
  scene::MotionSearch& motions() {
    if (!motions_) motions_.emplace(state);
    if (motions_->objects() != state.objects().get()) motions_->use(state.objects());
    return *motions_;
  }

  scene::State state;
  scene::Scene scene;

 private:
  std::optional<scene::GuaranteedDistances> guaranteed_;
  std::optional<scene::MotionSearch> motions_;
  std::optional<scene::PointSearch> points_;
  std::optional<scene::RaySearch> rays_;
};

/// Lends them to requests that run in parallel, and makes new ones if all are lent. Thread-safe.
///
/// A lease returns them to the pool when it is destroyed; the pool must outlive it.
class ScenePool {
 public:
  explicit ScenePool(const std::shared_ptr<const scene::SceneModel>& model) : state_(model), scene_(model) {}

  using Lease = std::unique_ptr<PosedScenes, std::function<void(PosedScenes*)>>;

  Lease borrow() {
    return Lease(idleOrNew().release(), [this](PosedScenes* scenes) {
      const std::lock_guard<std::mutex> lock(mutex_);
      idle_.emplace_back(scenes);
    });
  }

 private:
  std::unique_ptr<PosedScenes> idleOrNew() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<PosedScenes> scenes = std::move(idle_.back());
        idle_.pop_back();
        return scenes;
      }
    }
    return std::make_unique<PosedScenes>(state_, scene_);
  }

  const scene::State state_;
  const scene::Scene scene_;  ///< each lease begins with others made from these
  std::mutex mutex_;
  std::vector<std::unique_ptr<PosedScenes>> idle_;
};

}  // namespace proximity_server::node
