#pragma once

#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/state.h"
#include "scene/derivative/plane_figure.h"

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// A plane through a witness point, perpendicular to the normal, with coordinates [m] in it.
struct ContactPlane {
  Eigen::Vector2d inPlane(const Eigen::Vector3d& point) const { return axes.transpose() * (point - origin); }
  double heightOf(const Eigen::Vector3d& point) const { return normal.dot(point - origin); }

  Eigen::Vector3d origin;            ///< the witness point
  Eigen::Vector3d normal;            ///< unit vector that points out of the shape
  Eigen::Matrix<double, 3, 2> axes;  ///< the axes of the coordinates; unit vectors perpendicular to the normal
};

/// Sets `figure` to the points of a shape that are farthest along the normal of the plane, projected into the plane:
/// all points within `tolerance` [m] of the farthest. Returns the error [m] of their place in the plane, see
/// sidewaysError(), for bounds with this width [m]. Returns nullopt if the farthest points are not within `tolerance`
/// of the plane.
///
/// A disc that is the end of a swept cylinder or cone becomes a polygon around it.
std::optional<double> findSupportFigure(const narrowphase::Shape& shape, const Eigen::Isometry3d& frame_T_shape,
                                        const ContactPlane& plane, double tolerance, double width, PlaneFigure& figure);

/// The contact features of the pairs of one robot: the points that may be their witness points. It has the working
/// memory of one caller. Nothing is allocated if no shape has more vertices than the shapes of the robot and of the
/// objects before.
class ContactFeatures {
 public:
  explicit ContactFeatures(const SceneModel& model);

  /// The smallest value of slope . (x - point_a) over all points x that may be the witness point on the first shape of
  /// a pair with the normal of its result. The slope is perpendicular to the normal. It is at most 0, because point_a
  /// is one of these points.
  ///
  /// 1. Find the pieces of both links or objects that reach the plane through their witness point, and not beyond it.
  ///    The answer does not name the closest pieces, and there may be several.
  /// 2. Let d be the signed distance and n the normal. The witness pairs of two pieces are (x, x + d n) for all x in
  ///    both F_a and F_b - d n, where F_a and F_b are the points of the pieces that are farthest along n and -n. A
  ///    half-space has all points of its plane.
  /// 3. Projected along n, these x are the intersection of two plane figures. A linear function is smallest at a corner
  ///    of it.
  ///
  /// Error:   points count that miss the planes or each other by no more than the tolerance: the width of the bounds,
  ///          or the default tolerance of a Question if that is larger, plus the rounding of the poses. This can only
  ///          make the value smaller.
  /// Failure: NaN if the pose of one of the two is not known.
  double minimum(const State& state, const PairProximity& pair, const Eigen::Vector3d& slope);

 private:
  struct Side;

  void makeRoomFor(const Objects& objects);
  /// nullopt if the place is not known.
  std::optional<Side> sideOf(const ShapeRef& ref, const State& state) const;

  const RobotModel& robot_;
  std::vector<std::vector<int>> pieces_of_link_;
  const PairDistances paddings_;
  std::shared_ptr<const Objects> objects_;  ///< for which there is room
  PlaneFigure figure_a_, figure_b_;
};

}  // namespace proximity_server::scene
