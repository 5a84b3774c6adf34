#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "proximity_server/scene/scene.h"

namespace proximity_server {

/// Scenes of one model for requests that run in parallel: each takes one, and its destructor gives it back.
class ScenePool {
 public:
  explicit ScenePool(std::shared_ptr<const SceneModel> model) : first_(std::move(model)) {}

  using Lease = std::unique_ptr<Scene, std::function<void(Scene*)>>;

  Lease take() {
    return Lease(takeIdle().release(), [this](Scene* scene) {
      const std::lock_guard<std::mutex> lock(mutex_);
      idle_.emplace_back(scene);
    });
  }

 private:
  std::unique_ptr<Scene> takeIdle() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<Scene> scene = std::move(idle_.back());
        idle_.pop_back();
        return scene;
      }
    }
    return std::make_unique<Scene>(first_.twin());
  }

  const Scene first_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scene>> idle_;
};

}  // namespace proximity_server
