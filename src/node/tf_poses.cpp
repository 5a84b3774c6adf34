#include "tf_poses.h"

#include <ros/console.h>
#include <tf2/exceptions.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

namespace proximity_server {
namespace {

QueryStatus status(std::int8_t code, std::string message = {}) {
  QueryStatus result;
  result.code = code;
  result.message = std::move(message);
  return result;
}

/// What tf knows about one edge of the robot's tree.
struct Edge {
  std::string parent, child;
  std::string name;                       ///< for people
  ros::Time latest;                       ///< of its newest transform; 0 for a static one
  std::optional<Eigen::Isometry3d> pose;  ///< parent_T_child
  QueryStatus status;
};

/// tf itself refuses quaternions whose squared norm is further than this from 1.
constexpr double kUnitNormTolerance = 0.01;

std::optional<Eigen::Isometry3d> rigidMotion(const geometry_msgs::Transform& transform) {
  const Eigen::Vector3d translation(transform.translation.x, transform.translation.y, transform.translation.z);
  const Eigen::Quaterniond rotation(transform.rotation.w, transform.rotation.x, transform.rotation.y,
                                    transform.rotation.z);
  // Squared: a length whose square overflows leads to nothing but NaN.
  const bool is_finite = std::isfinite(translation.squaredNorm());
  if (!is_finite || !(std::abs(rotation.squaredNorm() - 1.0) <= kUnitNormTolerance)) return std::nullopt;
  return Eigen::Translation3d(translation) * rotation.normalized();
}

/// Looks the edge up at `stamp` (0: latest) and keeps what came of it.
void lookUpAt(const tf2::BufferCore& buffer, const ros::Time& stamp, Edge& edge) {
  edge.pose.reset();
  try {
    const geometry_msgs::TransformStamped found = buffer.lookupTransform(edge.parent, edge.child, stamp);
    if (stamp.isZero()) edge.latest = found.header.stamp;
    edge.pose = rigidMotion(found.transform);
    edge.status = edge.pose ? status(QueryStatus::OK)
                            : status(QueryStatus::TF_UNAVAILABLE,
                                     edge.name + ": its transform is not finite, or its quaternion has not length 1");
  } catch (const tf2::ExtrapolationException& error) {
    edge.status = status(QueryStatus::TF_EXTRAPOLATION, edge.name + ": " + error.what());
  } catch (const tf2::TransformException& error) {
    edge.status = status(QueryStatus::TF_UNAVAILABLE, edge.name + ": " + error.what());
  } catch (const std::runtime_error&) {  // of the arithmetic of ros::Time, which tf does not expect
    edge.status = status(QueryStatus::TF_EXTRAPOLATION, edge.name + ": its transforms are decades away from the stamp");
  }
}

bool available(const Edge& edge) { return edge.status.code == QueryStatus::OK; }

/// One edge for each of `joints`, then one to a reference frame that is foreign.
std::vector<Edge> edgesToLookUp(const Robot& robot, const std::vector<int>& joints) {
  const RobotModel& model = robot.links();
  const auto name = [&](int link) { return model.links[static_cast<std::size_t>(link)].name; };
  std::vector<Edge> edges;
  for (const int index : joints) {
    const Joint& joint = model.joints[static_cast<std::size_t>(index)];
    edges.push_back({name(joint.parent_link), name(joint.child_link), "joint '" + joint.name + "'", {}, {}, {}});
  }
  if (robot.referenceLink() < 0) {
    const std::string& frame = robot.referenceFrame();
    edges.push_back({frame, name(model.bodies.front().link), "reference_frame '" + frame + "'", {}, {}, {}});
  }
  return edges;
}

void take(const std::vector<Edge>& edges, const std::vector<int>& joints, JointSnapshot& snapshot) {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    snapshot.joints[static_cast<std::size_t>(joints[i])] = edges[i].pose;
  }
  if (edges.size() > joints.size()) snapshot.reference_T_root = edges.back().pose;
}

PoseSnapshot placed(const Robot& robot, const JointSnapshot& joints) {
  return {inReference(robot, posesInRoot(robot.links(), joints.joints), joints.reference_T_root), joints.stamp,
          joints.age, joints.skew, joints.status};
}

/// Stamps come from outside; ros::Duration itself throws where they are more than 68 years apart.
ros::Duration elapsed(const ros::Time& from, const ros::Time& to) {
  constexpr std::int64_t kLongest = 2'000'000'000'000'000'000;  // [ns]
  const std::int64_t difference = static_cast<std::int64_t>(to.toNSec()) - static_cast<std::int64_t>(from.toNSec());
  return ros::Duration().fromNSec(std::clamp(difference, -kLongest, kLongest));
}

std::string seconds(const ros::Duration& duration) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", duration.toSec());
  return text;
}

/// The first edge that is not available speaks for all of them; OK where there is none.
QueryStatus summary(const std::vector<Edge>& edges) {
  const auto broken = [](const Edge& edge) { return !available(edge); };
  const auto first = std::find_if(edges.begin(), edges.end(), broken);
  if (first == edges.end()) return {};
  QueryStatus result = first->status;
  const auto count = std::count_if(edges.begin(), edges.end(), broken);
  if (count > 1) result.message += " (and " + std::to_string(count - 1) + " more)";
  return result;
}

/// Earliest and newest of the latest transforms that move at all.
struct CommonTime {
  const Edge* oldest = nullptr;
  const Edge* newest = nullptr;
};
CommonTime commonTime(const std::vector<Edge>& edges) {
  CommonTime common;
  for (const Edge& edge : edges) {
    if (!available(edge) || edge.latest.isZero()) continue;
    if (!common.oldest || edge.latest < common.oldest->latest) common.oldest = &edge;
    if (!common.newest || edge.latest > common.newest->latest) common.newest = &edge;
  }
  return common;
}

QueryStatus freshness(const CommonTime& common, const ros::Time& now, const ros::Duration& max_age) {
  if (elapsed(common.oldest->latest, now) > max_age) {
    return status(QueryStatus::TF_STALE, common.oldest->name + ": its latest transform is " +
                                             seconds(elapsed(common.oldest->latest, now)) + " old, max_tf_age is " +
                                             seconds(max_age));
  }
  if (elapsed(now, common.newest->latest) > max_age) {
    return status(QueryStatus::TF_STALE, common.newest->name + ": its latest transform is " +
                                             seconds(elapsed(now, common.newest->latest)) + " ahead of the clock");
  }
  return {};
}

}  // namespace

void TfPoses::onChange(std::function<void()> listener) {
  const std::lock_guard<std::mutex> lock(mutex_);
  listener_ = std::move(listener);
}

void TfPoses::transformsChanged() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++changes_;
  changed_.notify_all();
  if (listener_) listener_();
}

ros::Time TfPoses::readClock() {
  // Read under the lock: else a thread that is overtaken by another sees a jump that never was.
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time now = ros::Time::now();
  if (now < last_now_) {
    ROS_WARN_STREAM("the clock jumped back by " << seconds(elapsed(now, last_now_)) << ": forgetting all transforms");
    tree_.clear();
  }
  last_now_ = now;
  return now;
}

PoseSnapshot TfPoses::lookUp(const Robot& robot, const std::vector<int>& bodies, const ros::Time& stamp) {
  return placed(robot, lookUpJoints(robot, jointsTo(robot, bodies), stamp));
}

PoseSnapshot TfPoses::await(const Robot& robot, const std::vector<int>& bodies, const ros::Time& stamp) {
  return placed(robot, awaitJoints(robot, jointsTo(robot, bodies), stamp));
}

JointSnapshot TfPoses::lookUpJoints(const Robot& robot, const std::vector<int>& joints, const ros::Time& stamp) {
  JointSnapshot snapshot;
  snapshot.stamp = stamp;
  snapshot.joints.resize(robot.links().joints.size());
  const ros::Time now = readClock();
  if (now.isZero()) {
    snapshot.status = status(QueryStatus::TF_UNAVAILABLE, "waiting for the clock: use_sim_time is set, /clock is not");
    return snapshot;
  }

  std::vector<Edge> edges = edgesToLookUp(robot, joints);
  const std::shared_ptr<const tf2::BufferCore> buffer = tree_.buffer();
  for (Edge& edge : edges) lookUpAt(*buffer, ros::Time(), edge);
  const CommonTime common = commonTime(edges);
  snapshot.status = summary(edges);
  if (!common.oldest && snapshot.status.code != QueryStatus::OK) return snapshot;
  if (common.oldest) snapshot.skew = elapsed(common.oldest->latest, common.newest->latest);

  const ros::Time latest = common.oldest ? common.oldest->latest : now;  // any time will do where nothing moves
  snapshot.stamp = stamp.isZero() ? latest : stamp;
  snapshot.age = elapsed(snapshot.stamp, now);
  if (stamp.isZero() && common.oldest) {
    const ros::Duration max_age(robot.config().max_tf_age);
    snapshot.status = freshness(common, now, max_age);
    // Left over from before a jump of the clock: tf would refuse everything that is older.
    if (elapsed(now, common.newest->latest) > max_age) tree_.clear();
    if (snapshot.status.code != QueryStatus::OK) return snapshot;
  }
  for (Edge& edge : edges) {
    if (available(edge)) lookUpAt(*buffer, snapshot.stamp, edge);
  }
  snapshot.status = summary(edges);
  take(edges, joints, snapshot);
  return snapshot;
}

JointSnapshot TfPoses::awaitJoints(const Robot& robot, const std::vector<int>& joints, const ros::Time& stamp) {
  // Wall time: a simulated clock may stand still.
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(robot.config().tf_timeout);
  while (true) {
    std::unique_lock<std::mutex> lock(mutex_);
    const std::uint64_t seen = changes_;
    lock.unlock();
    JointSnapshot snapshot = lookUpJoints(robot, joints, stamp);
    if (snapshot.status.code == QueryStatus::OK) return snapshot;
    lock.lock();
    if (!changed_.wait_until(lock, deadline, [&] { return changes_ != seen; })) return snapshot;
  }
}

}  // namespace proximity_server
