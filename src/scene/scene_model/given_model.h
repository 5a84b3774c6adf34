#pragma once

#include "proximity_server/scene/scene_model/scene_model.h"

#include <memory>
#include <stdexcept>

namespace proximity_server::scene {

/// Throws std::invalid_argument if there is no model.
inline const SceneModel& given(const std::shared_ptr<const SceneModel>& model) {
  if (!model) throw std::invalid_argument("there is no model of a robot");
  return *model;
}

/// Lends a model to a scene, which must be destroyed before the model.
inline std::shared_ptr<const SceneModel> lent(const SceneModel& model) { return {std::shared_ptr<void>(), &model}; }

}  // namespace proximity_server::scene
