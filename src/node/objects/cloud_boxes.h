#pragma once

#include "node/objects/tracked_ages.h"
#include "node/robot/robot.h"
#include "proximity_server/scene/objects/object_shape.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/sensed/self_filter.h"
#include "proximity_server/scene/sensed/voxel_grid.h"

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::node {

/// Makes boxes of the clouds of a sensed source, with the working memory of one thread.
class CloudBoxes {
 public:
  explicit CloudBoxes(const Sensing& sensing) : sensing_(sensing), grid_(sensing.resolution) {}

  /// The bodies with geometry. The self filter needs their poses.
  static std::vector<int> bodiesOf(const Robot& robot);

  /// Leaves out the points that are out of range, and those of the robot and of what it holds at these poses, and returns
  /// the voxels of the others as one shape; none without points. `points` [m] are in the frame of the sensor, which
  /// stands at `pose` in the reference frame; on return they are in the reference frame, without those that are left out.
  /// Failure: throws as scene::SelfFilter does. The points are undefined then.
  std::vector<scene::ObjectShape> make(const std::shared_ptr<const Robot>& robot, const scene::Objects& objects,
                                       const scene::BodyPoses& poses, const Eigen::Isometry3d& pose,
                                       std::vector<Eigen::Vector3d>& points, SensedCloud& cloud);

 private:
  void follow(const std::shared_ptr<const Robot>& robot);

  Sensing sensing_;
  scene::VoxelGrid grid_;
  std::shared_ptr<const Robot> robot_;
  scene::SelfPadding padding_;
  std::optional<scene::SelfFilter> filter_;
  std::optional<scene::State> state_;
};

}  // namespace proximity_server::node
