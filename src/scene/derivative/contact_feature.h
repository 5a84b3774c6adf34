#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/derivative/plane_figure.h"

namespace proximity_server::scene {

/// A plane through a witness point across the normal, with coordinates [m] in it.
struct ContactPlane {
  Eigen::Vector2d inPlane(const Eigen::Vector3d& point) const { return axes.transpose() * (point - origin); }
  double heightOf(const Eigen::Vector3d& point) const { return normal.dot(point - origin); }

  Eigen::Vector3d origin;            ///< the witness point
  Eigen::Vector3d normal;            ///< unit, out of the shape
  Eigen::Matrix<double, 3, 2> axes;  ///< of the coordinates; unit, and across the normal
};

/// Sets `figure` to the points of a shape that are farthest along the normal of the plane, seen in the plane: all that are
/// within `tolerance` [m] of the farthest. Returns how far they may lie beside their true place [m], see sidewaysError(), for
/// bounds with this gap [m]; nullopt if the farthest points are not within `tolerance` of the plane.
///
/// A disc that is the end of a swept cylinder or cone becomes a polygon around it.
std::optional<double> findSupportFigure(const narrowphase::Shape& shape, const Eigen::Isometry3d& frame_T_shape,
                                        const ContactPlane& plane, double tolerance, double gap, PlaneFigure& figure);

/// The contact features of the pairs of one robot: where their witness points may be. It is the scratch of one caller, and
/// allocates nothing after use() where no shape has more vertices than those of the robot and its objects.
class ContactFeatures {
 public:
  explicit ContactFeatures(const SceneModel& model);

  /// nullptr: none.
  void use(std::shared_ptr<const Objects> objects);

  /// The smallest value of slope . (x - point_a) over the witness points x that a pair may have on the first of the two
  /// with the normal of its result, for a slope across the normal. 0 or less, as point_a is one of them.
  ///
  /// 1. Find the pieces of both links or objects that reach the plane through their witness point, and no farther. The answer
  ///    does not name the closest ones, and there may be several.
  /// 2. With d the signed distance and n the normal, the witness pairs of two pieces are (x, x + d n), with x in F_a and in
  ///    F_b - d n, where F_a and F_b are the points of the pieces that are farthest along n and -n. A half-space has all
  ///    points of its plane.
  /// 3. Seen along n that is the intersection of two plane figures; a linear function is smallest at a corner of it.
  ///
  /// Error:   points that miss the planes or each other by no more than the tolerance count: that is the gap of the bounds and
  ///          at least that of a Question by default, and the rounding of the poses. It makes the value smaller only.
  /// Failure: NaN if the place of one of them is not known.
  double least(const PairProximity& pair, const Eigen::Vector3d& slope, const BodyPoses& poses,
               const FramePoses& frames);

 private:
  struct Side;

  /// nullopt if the place is not known.
  std::optional<Side> sideOfLink(const ShapeRef& ref, const BodyPoses& poses) const;
  std::optional<Side> sideOfObject(const ShapeRef& ref, const BodyPoses& poses, const FramePoses& frames) const;

  const SceneModel& model_;
  const PairDistances paddings_;
  std::vector<std::vector<int>> pieces_of_link_;
  std::shared_ptr<const Objects> objects_;
  PlaneFigure figure_a_, figure_b_;
};

}  // namespace proximity_server::scene
