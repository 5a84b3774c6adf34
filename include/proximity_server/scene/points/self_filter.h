#pragma once

#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/state.h"

#include <Eigen/Core>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// How near to the robot a point of a sensor counts as one of its own [m].
struct SelfPadding {
  double of_all = 0.0;
  std::map<int, double> of_links{};            ///< by the number of the link; also of what it holds
  std::map<std::string, double> of_objects{};  ///< by name, also of objects that no link holds; they may be missing
};

/// Takes the points of a sensor that are on a robot, or on what it holds, out of a cloud. With the working memory of one
/// caller; not thread-safe.
///
/// 1. Put the points into voxels. List for each brick of them the pieces of the robot whose bounds are within the padding
///    of a ball about it.
/// 2. Divide the brick by halves, down to voxels. The ball about a block keeps the pieces that may be within the padding:
///    if none is left, its points stay; if it is wholly within the padding of one, all of them are removed.
/// 3. Compare only the points of the other voxels with the pieces that are left of their voxel, one by one.
class SelfFilter {
 public:
  /// Throws std::invalid_argument without a model, and as VoxelGrid does for the edge [m] of the voxels, which changes the
  /// time and no answer.
  SelfFilter(std::shared_ptr<const SceneModel> model, double resolution);
  ~SelfFilter();
  SelfFilter(SelfFilter&&) noexcept;
  SelfFilter& operator=(SelfFilter&&) noexcept;

  /// Removes the points [m], in the frame of the state, whose distance from a link with geometry, or from an object that
  /// a link holds or that has a padding of its own, is at most its padding. The others keep their order. Returns the number of removed points.
  ///
  /// Error:   Question::tolerance.
  /// Failure: throws std::invalid_argument as VoxelGrid does, for a padding that is negative or not finite, and naming the
  ///          first shape without a pose; std::runtime_error after the deadline. The points are unchanged then.
  std::size_t remove(const State& state, const SelfPadding& padding, std::vector<Eigen::Vector3d>& points,
                     const Question& question = {});

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace proximity_server::scene
