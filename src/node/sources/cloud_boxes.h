#pragma once

#include "node/robot/robot.h"
#include "node/sources/tracked_ages.h"
#include "proximity_server/scene/objects/object_shape.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/points/self_filter.h"
#include "proximity_server/scene/sensed/sight_rays.h"
#include "proximity_server/scene/sensed/voxel_memory.h"

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::node {

/// Makes boxes of the clouds of a sensed source, with the working memory of one thread.
class CloudBoxes {
 public:
  explicit CloudBoxes(const Sensing& sensing) : sensing_(sensing), memory_(sensing.resolution, sensing.persistence) {}

  /// The bodies with geometry. The self filter needs their poses.
  static std::vector<int> bodiesOf(const Robot& robot);

  /// Where everything is at the time of a cloud, in the reference frame.
  struct Moment {
    double time = 0.0;                                         ///< [s]
    Eigen::Isometry3d sensor = Eigen::Isometry3d::Identity();  ///< without points it does not count
    scene::BodyPoses poses{};                                  ///< the same
  };

  /// Leaves out the points that are more than the limit, out of range, or of the robot and of what it holds, and returns
  /// the voxels of the others and those that persist as one shape; none without voxels. `points` [m] are in the frame of
  /// the sensor; on return they are in the reference frame, without those that are left out.
  /// Failure: throws as scene::SelfFilter does. The points are undefined then.
  std::vector<scene::ObjectShape> make(const std::shared_ptr<const Robot>& robot, const scene::Objects& objects,
                                       const Moment& at, std::vector<Eigen::Vector3d>& points, SensedCloud& cloud);

 private:
  void follow(const std::shared_ptr<const Robot>& robot);
  void place(const Eigen::Isometry3d& sensor, std::vector<Eigen::Vector3d>& points, SensedCloud& cloud);
  void removeOwn(const scene::Objects& objects, const scene::BodyPoses& poses, std::vector<Eigen::Vector3d>& points,
                 SensedCloud& cloud);

  Sensing sensing_;
  scene::VoxelMemory memory_;
  std::vector<Eigen::Vector3d> ends_;  ///< [m] of the rays that clear
  scene::SightRays rays_;
  std::shared_ptr<const Robot> robot_;
  scene::SelfPadding padding_;
  std::optional<scene::SelfFilter> filter_;
  std::optional<scene::State> state_;
};

}  // namespace proximity_server::node
