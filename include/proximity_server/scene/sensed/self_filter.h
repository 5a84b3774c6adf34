#pragma once

#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/sensed/voxel_grid.h"
#include "proximity_server/scene/state/state.h"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace proximity_server::scene {

/// How near to the robot a point of a sensor counts as one of its own [m].
struct SelfPadding {
  double of_all = 0.0;
  std::map<int, double> of_links{};  ///< by the number of the link; also of what it holds
};

/// Takes the points of a sensor that are on a robot, or on what it holds, out of a cloud. With the working memory of one
/// caller; not thread-safe.
///
/// 1. Put the points into voxels. Balls about bricks that are farther than the padding keep all their points.
/// 2. So do balls about voxels; voxels that are wholly within the padding lose all of them.
/// 3. Only the points of the other voxels are asked about one by one.
class SelfFilter {
 public:
  /// Throws std::invalid_argument without a model, and as VoxelGrid does for the edge [m] of the voxels, which changes the
  /// time and no answer.
  SelfFilter(std::shared_ptr<const SceneModel> model, double resolution);

  /// Removes the points [m], in the frame of the state, whose distance from a link with geometry, or from an object that
  /// a link holds, is at most its padding. The others keep their order. Returns the number of removed points.
  ///
  /// Error:   Question::tolerance.
  /// Failure: throws std::invalid_argument as VoxelGrid does, for a padding that is negative or not finite, and naming the
  ///          first shape without a pose; std::runtime_error after the deadline. The points are unchanged then.
  std::size_t remove(const State& state, const SelfPadding& padding, std::vector<Eigen::Vector3d>& points,
                     const Question& question = {});

 private:
  enum class Fate : unsigned char { Kept, Open, Removed };
  struct Same {
    double padding;
    std::vector<ShapeRef> shapes;
  };

  static std::vector<Same> groupsOf(const State& state, const SelfPadding& padding);
  void removeNear(const State& state, const Same& group, const std::vector<Eigen::Vector3d>& points,
                  const Question& question);
  const std::vector<PairProximity>& ask(const State& state, const Same& group, const Question& question);
  Fate fateOf(const VoxelGrid::Voxel& voxel) const;

  PointSearch search_;
  VoxelGrid grid_;
  std::vector<VoxelGrid::Voxel> voxels_;  ///< of the points
  std::vector<bool> is_removed_;          ///< the points
  static constexpr std::size_t kFar = SIZE_MAX;
  std::vector<std::size_t> near_;   ///< for each brick its number among those that are near a group, or kFar
  std::vector<Fate> fates_;         ///< of the voxels of these bricks
  std::vector<std::size_t> asked_;  ///< points
  std::vector<VoxelGrid::Voxel> asked_voxels_;
  Points balls_;
};

}  // namespace proximity_server::scene
