#pragma once

#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/scene_model/shape_ref.h"
#include "proximity_server/scene/state/state.h"

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace proximity_server::scene {

/// Points that are no part of a scene, or balls about them.
struct Points {
  std::vector<Eigen::Vector3d> centres;  ///< [m] in the frame of the poses
  std::vector<double> radii{};           ///< [m] one for each, or one for all; empty: 0
  std::vector<ShapeRef> shapes{};        ///< links, <collision> elements and objects; empty: see shapesOfRobot()
};

/// Throws std::invalid_argument for a point that is not finite and for a radius that is negative or not finite, by their
/// numbers, counted from 0; and for a wrong number of radii.
void requireValid(const Points& points);

/// All links with geometry, and all objects that links hold.
std::vector<ShapeRef> shapesOfRobot(const RobotModel& robot, const Objects& objects);

/// Finds how far points are from a robot: for each point the closest of the shapes, with the working memory of one
/// caller. Not thread-safe. Nothing is allocated when it is asked again about as many points and the same shapes in the same
/// state.
///
/// 1. Walk a tree of boxes about the shapes, the nearer box first.
/// 2. Skip a shape whose sphere or box is farther than what was found, or than the threshold.
/// 3. Find the closest piece of all others, as Scene does for the pair of the shape and the ball.
class PointSearch {
 public:
  /// Throws std::invalid_argument without a model.
  explicit PointSearch(std::shared_ptr<const SceneModel> model, Skipping skipping = Skipping::On);
  ~PointSearch();
  PointSearch(PointSearch&&) noexcept;
  PointSearch& operator=(PointSearch&&) noexcept;

  /// One answer for each point: `a` is the closest shape, `b` is ShapeRef::ofPoint() of its number. The reference is
  /// valid until the next question.
  /// Frame:    the frame of the poses. Metres.
  /// Sign:     negative inside: minus the shortest way out of a piece or of the inside of a closed mesh. That of the
  ///           whole shape may be longer where `depth_is_lower_bound`. For a ball, its radius is subtracted.
  /// Error:    Question::tolerance, as for pairs; the bounds include the rounding of poses and coordinates. The same bits
  ///           alone and among other points, in any order.
  /// Distance: only a lower bound beyond the threshold, with Status::Threshold; then `a` names nothing.
  /// Failure:  Status::Unknown after the deadline, or if no shape has a known pose. Shapes without a pose are left out,
  ///           see unplaced().
  ///           Throws as requireValid(), and std::invalid_argument for a shape that does not exist and for a state of
  ///           another robot.
  const std::vector<PairProximity>& closest(const State& state, const Points& points, const Question& question = {});

  /// The shapes of the last question that were left out, because their poses are not known.
  const std::vector<ShapeRef>& unplaced() const;

  /// The points of the last question by what settled them: computed, or the bounds alone.
  const PairCounts& counts() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace proximity_server::scene
