#pragma once

#include "node/robot/robot.h"
#include "node/tf/tf_tree.h"
#include "proximity_server/QueryStatus.h"

#include <geometry_msgs/Transform.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace proximity_server::node {

/// The transform that tf has for one edge of a robot's tree.
struct EdgeTransform {
  ros::Time stamp;                        ///< 0 for a static transform
  std::optional<Eigen::Isometry3d> pose;  ///< parent_T_child
  QueryStatus status;                     ///< OK, or the reason why there is no pose, with the name of the joint
};

/// Converts a transform. Returns nullopt if a number is not finite or the quaternion does not have length 1.
std::optional<Eigen::Isometry3d> rigidMotion(const geometry_msgs::Transform& transform);

/// Looks up the transform at `stamp`, or the latest one if `stamp` is 0.
EdgeTransform lookUpEdge(const tf2::BufferCore& buffer, const TfEdge& edge, const ros::Time& stamp);

/// A cache of the latest transforms of a robot's edges. Each edge is looked up once between two messages of tf, however
/// many requests there are. Thread-safe.
class LatestTransforms {
 public:
  struct Edge {
    int number;            ///< index into Robot::tfEdges()
    const TfEdge* frames;  ///< the edge of that index
    EdgeTransform transform;
  };

  /// Sets Edge::transform of each edge to its latest transform.
  void find(const TfTree::View& tf, const Robot& robot, std::vector<Edge>& edges);

 private:
  struct Entry {
    std::optional<std::uint64_t> changes;  ///< TfTree::View::changes at the look-up
    EdgeTransform transform;
  };

  std::mutex mutex_;
  std::shared_ptr<const std::vector<TfEdge>> edges_;  // one for each entry
  std::vector<Entry> entries_;
};

}  // namespace proximity_server::node
