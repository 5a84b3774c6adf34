#include "node/tf/edge_transforms.h"

#include "node/robot/query_status.h"

#include <tf2/exceptions.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

/// tf refuses quaternions whose squared norm differs from 1 by more than this, too.
constexpr double kUnitNormTolerance = 0.01;

QueryStatus statusOfEdge(std::int8_t code, const TfEdge& edge, const std::string& why) {
  return statusOf(code, edge.name + ": " + why);
}

}  // namespace

std::optional<Eigen::Isometry3d> rigidMotion(const geometry_msgs::Transform& transform) {
  const Eigen::Vector3d translation(transform.translation.x, transform.translation.y, transform.translation.z);
  const Eigen::Quaterniond rotation(transform.rotation.w, transform.rotation.x, transform.rotation.y,
                                    transform.rotation.z);
  // The squared norm is checked, because a length whose square overflows would give NaN later.
  const bool is_finite = std::isfinite(translation.squaredNorm());
  if (!is_finite || !(std::abs(rotation.squaredNorm() - 1.0) <= kUnitNormTolerance)) return std::nullopt;
  return Eigen::Translation3d(translation) * rotation.normalized();
}

EdgeTransform lookUpEdge(const tf2::BufferCore& buffer, const TfEdge& edge, const ros::Time& stamp) {
  EdgeTransform result;
  try {
    const geometry_msgs::TransformStamped found = buffer.lookupTransform(edge.parent, edge.child, stamp);
    result.stamp = found.header.stamp;
    result.pose = rigidMotion(found.transform);
    if (!result.pose) {
      result.status = statusOfEdge(QueryStatus::TF_UNAVAILABLE, edge,
                                   "its transform is not finite, or its quaternion has not length 1");
    }
  } catch (const tf2::ExtrapolationException& error) {
    result.status = statusOfEdge(QueryStatus::TF_EXTRAPOLATION, edge, error.what());
  } catch (const tf2::TransformException& error) {
    result.status = statusOfEdge(QueryStatus::TF_UNAVAILABLE, edge, error.what());
  } catch (const std::runtime_error&) {  // thrown by ros::Time for an overflow, which tf does not handle
    result.status = statusOfEdge(QueryStatus::TF_EXTRAPOLATION, edge, "its transforms are decades away from the stamp");
  }
  return result;
}

void LatestTransforms::find(const TfTree::View& tf, const Robot& robot, std::vector<Edge>& edges) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (edges_ != robot.tfEdges()) {
    edges_ = robot.tfEdges();
    entries_.assign(edges_->size(), {});
  }
  for (Edge& edge : edges) {
    Entry& entry = entries_[edge.number];
    if (entry.changes != tf.changes) entry = {tf.changes, lookUpEdge(*tf.buffer, *edge.frames, ros::Time())};
    edge.transform = entry.transform;
  }
}

}  // namespace proximity_server::node
