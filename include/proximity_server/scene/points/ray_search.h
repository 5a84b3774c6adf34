#pragma once

#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/scene_model/shape_ref.h"
#include "proximity_server/scene/state/state.h"

#include <Eigen/Core>

#include <limits>
#include <memory>
#include <vector>

namespace proximity_server::scene {

struct Ray {
  Eigen::Vector3d origin;                                  ///< [m] in the frame of the poses
  Eigen::Vector3d direction;                               ///< of any length
  double range = std::numeric_limits<double>::infinity();  ///< [m]
};

/// The first place where a ray meets a shape, or the proof that it is free.
struct RayHit {
  /// Converged: either `shape` is hit, or the ray is free along its range. IterationLimit, Degenerate: it is known to be
  /// free until `free` only. Unknown: the deadline came first, or numbers overflow.
  narrowphase::Status status = narrowphase::Status::Unknown;
  ShapeRef shape;     ///< the <collision> of a link, or the shape of an object; Kind::None without a hit
  double free = 0.0;  ///< [m] along the ray: nothing is nearer
  double distance = std::numeric_limits<double>::quiet_NaN();  ///< [m] along the ray; NaN without a hit
  Eigen::Vector3d normal = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());  ///< of the surface

  Eigen::Vector3d pointOn(const Ray& ray) const { return ray.origin + distance * ray.direction.stableNormalized(); }
};

/// Throws std::invalid_argument for an origin or direction that is not finite, a direction of 0, and a range that is not
/// positive, by their numbers, counted from 0.
void requireValid(const std::vector<Ray>& rays);

/// All links with geometry, and all objects.
std::vector<ShapeRef> allShapes(const RobotModel& robot, const Objects& objects);

/// Finds what rays meet first, with the working memory of one caller. Not thread-safe. It allocates as PointSearch does.
///
/// 1. Walk a tree of boxes about the shapes, and the volumes of each shape, in the order in which the ray enters them.
/// 2. Move a point along the ray to each convex piece by conservative advancement (narrowphase::timeOfContact()); a
///    half-space has a formula.
/// 3. A ray that begins inside a piece, or inside a closed mesh, hits at 0.
///
/// Source: van den Bergen, Ray Casting against General Convex Objects with Application to Continuous Collision Detection,
///         2004. Differs: a ray that is reported as free is proven to be free.
class RaySearch {
 public:
  /// Throws std::invalid_argument without a model.
  explicit RaySearch(std::shared_ptr<const SceneModel> model);
  ~RaySearch();
  RaySearch(RaySearch&&) noexcept;
  RaySearch& operator=(RaySearch&&) noexcept;

  /// One answer for each ray. `shapes`: links, <collision> elements and objects; empty: allShapes(). The reference is
  /// valid until the next question.
  /// Frame:   the frame of the poses. Metres.
  /// Error:   at `distance` the ray is within the tolerance and the rounding of the poses from the surface, and before
  ///          `free` it is farther. A ray that passes the surface as near as that may count as a hit. The same bits alone
  ///          and among other rays, in any order.
  /// Failure: Status::Unknown after the deadline. Shapes without a pose are left out, see unplaced().
  ///          Throws as requireValid(), and std::invalid_argument for a shape that does not exist and for a state of
  ///          another robot.
  const std::vector<RayHit>& firstHits(const State& state, const std::vector<Ray>& rays,
                                       const std::vector<ShapeRef>& shapes = {}, const Question& question = {});

  /// The shapes of the last question that were left out, because their poses are not known.
  const std::vector<ShapeRef>& unplaced() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace proximity_server::scene
