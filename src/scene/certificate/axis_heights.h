#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Geometry>

#include <limits>
#include <vector>

namespace proximity_server::scene {

/// Rounding relative to the lengths of a chain of transforms, for each of them; see AxisHeights::rounding().
inline constexpr double kChainRounding = 64.0 * std::numeric_limits<double>::epsilon();

/// The box with another interval of a joint.
std::vector<JointRange> withInterval(std::vector<JointRange> box, const JointRange& interval);

/// The heights of the points of one body along an axis that is fixed to another body, in all states of a box.
///
/// In one state the height of a point p, in the frame of its body, is direction . p + offset. Such a function for each
/// state lies in the convex hull of finitely many; so the largest height over a shape and all states is the largest
/// support height of the shape along the directions of these.
///
/// 1. Begin with the axis in its own frame, and walk from joint to joint to the body.
/// 2. A fixed transform turns the direction and shifts the offset.
/// 3. A turn by q maps a direction d to along + cos(q) across + sin(q) (a x d), with the parts of d along and across the
///    axis a of the joint. All (cos(q), sin(q)) of the interval lie in a polygon: the two ends of the arc, and points
///    where two of its tangents meet. So each function is replaced by one for each corner.
/// 4. A slide by q shifts the offset by q a . d, which lies between its values at the ends of the interval.
/// 5. If there would be too many functions, a disc about the arc takes the place of the polygon: the function at its
///    centre, whose direction is off by no more than the radius allows.
///
/// A mimic joint has an interval of its own, which follows from the interval of its leader.
class AxisHeights {
 public:
  /// `direction`: a unit vector in the frame of the body `from`; the points belong to the body `to`. The box has an
  /// interval for each joint between the two, or for its leader.
  AxisHeights(const RobotModel& robot, const std::vector<JointRange>& box, int from, int to,
              const Eigen::Vector3d& direction);

  /// [m] No point of the shape is higher in any state. `reach` [m]: no point of its core is farther from the frame of
  /// the body, and the transforms that place it there are not longer.
  double highest(const narrowphase::Shape& shape, const Eigen::Isometry3d& body_T_shape, double reach) const;

  /// [m] The height of a point, if the box is one state.
  double of(const Eigen::Vector3d& point) const;

 private:
  /// The height of p is (direction + e) . p + offset + f for an e that is no longer than direction_error, and an f of
  /// at most offset_error [m].
  struct Height {
    Eigen::Vector3d direction;
    double offset = 0.0, direction_error = 0.0, offset_error = 0.0;
  };

  void move(const Joint& joint, const JointRange& interval, double sign);
  void turn(const Eigen::Vector3d& axis, const JointRange& angles);
  void slide(const Eigen::Vector3d& axis, const JointRange& way);
  void enter(const Eigen::Isometry3d& here_T_next);
  double rounding(const Height& height, double reach) const;

  std::vector<Height> heights_;
  double steps_ = 1.0, lengths_ = 0.0;  ///< sums of 1 + |q|, and of lengths [m], on the way
};

}  // namespace proximity_server::scene
