#include "node/tf/tf_poses.h"

#include "node/robot/query_status.h"
#include "node/robot/tf_frames.h"
#include "node/threads/request_queue.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/durations.h"

#include <ros/console.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

bool isAvailable(const TfLookup::Edge& edge) { return edge.transform.status.code == QueryStatus::OK; }

/// Clears a snapshot, and sets its stamp.
void clearSnapshot(const ros::Time& stamp, JointSnapshot& snapshot) {
  std::fill(snapshot.joints.begin(), snapshot.joints.end(), std::nullopt);
  std::fill(snapshot.roots.begin(), snapshot.roots.end(), std::nullopt);
  std::fill(snapshot.stated.begin(), snapshot.stated.end(), std::nullopt);
  snapshot.stamp = stamp;
  snapshot.age = snapshot.skew = ros::Duration();
  snapshot.status = {};
}

/// The robot of an edge, as an index into RobotModel::robots.
int robotOf(const Robot& robot, int edge) {
  const scene::RobotModel& model = robot.robotModel();
  if (edge < static_cast<int>(model.joints.size()))
    return model.bodies[model.links[model.joints[edge].child_link].body].robot;
  int number = 0;
  while (robot.rootEdge(number) != edge) ++number;
  return number;
}

/// Copies the transforms of the edges into the snapshot.
void copyTransforms(TfLookup& lookup) {
  JointSnapshot& found = lookup.joint_snapshot;
  for (const TfLookup::Edge& edge : lookup.edges) {
    const bool is_joint = edge.number < static_cast<int>(found.joints.size());
    (is_joint ? found.joints[edge.number] : found.roots[robotOf(*lookup.robot, edge.number)]) = edge.transform.pose;
  }
}

/// Sets the positions of the joints whose turns are told.
void findTurns(const StatedJoints::View& stated, TfLookup& lookup) {
  JointSnapshot& found = lookup.joint_snapshot;
  for (const TfLookup::Edge& edge : lookup.edges) {
    if (edge.number >= static_cast<int>(found.joints.size()) || !found.joints[edge.number]) continue;
    if (const StatedJoints::Entry* const entry = stated.find(*lookup.robot, edge.number))
      found.stated[edge.number] =
          onStatedTurn(*lookup.robot, edge.number, *found.joints[edge.number], found.stamp, *entry);
  }
}

/// Sets all but PoseSnapshot::beyond, in the memory that the snapshot has.
void assignPoses(const Robot& robot, const JointSnapshot& joints, PoseSnapshot& snapshot) {
  snapshot.poses =
      inReference(robot, posesInRoot(robot.robotModel(), joints.joints, std::move(snapshot.poses)), joints.roots);
  snapshot.stamp = joints.stamp;
  snapshot.age = joints.age;
  snapshot.skew = joints.skew;
  snapshot.status = joints.status;
  snapshot.stated = joints.stated;
}

/// The difference of two stamps, clamped to 63 years: stamps of other programs may have any value, and ros::Duration
/// throws for more than 68 years.
ros::Duration elapsed(const ros::Time& from, const ros::Time& to) {
  constexpr std::int64_t kLongest = 2'000'000'000'000'000'000;  // [ns]
  const std::int64_t difference = static_cast<std::int64_t>(to.toNSec()) - static_cast<std::int64_t>(from.toNSec());
  return ros::Duration().fromNSec(std::clamp(difference, -kLongest, kLongest));
}

/// Formats a duration for a message, rounded to milliseconds: "0.512 s".
std::string durationText(const ros::Duration& duration) {
  return system::secondsText(1e-3 * std::round(1e3 * duration.toSec()));
}

/// The links of the robot at the ends of an edge, as the URDF names them.
std::vector<std::string> linksOf(const scene::RobotModel& robot, int member, int edge) {
  const auto name = [&](int link) { return robot.robots[member].ownName(robot.links[link].name); };
  if (edge >= static_cast<int>(robot.joints.size())) return {name(robot.bodies[robot.roots()[member]].link)};
  const scene::Joint& joint = robot.joints[edge];
  return {name(joint.parent_link), name(joint.child_link)};
}

/// Tells what to do if tf does not know an edge because of the prefix of its robot. Returns "" if the prefix is not the
/// cause.
std::string hintFor(const tf2::BufferCore& buffer, const Robot& robot, int edge) {
  const int member = robotOf(robot, edge);
  const RobotSource& source = robot.sources()[member];
  return prefixHint(buffer, source, linksOf(robot.robotModel(), member, edge));
}

/// The status of the first edge that is not available, with the number of such edges; OK if all are available.
QueryStatus summary(const TfLookup& lookup, const tf2::BufferCore& buffer) {
  const std::vector<TfLookup::Edge>& edges = lookup.edges;
  const auto broken = [](const TfLookup::Edge& edge) { return !isAvailable(edge); };
  const auto first = std::find_if(edges.begin(), edges.end(), broken);
  if (first == edges.end()) return {};
  QueryStatus result = first->transform.status;
  const auto count = std::count_if(edges.begin(), edges.end(), broken);
  if (count > 1) result.message += " (and " + std::to_string(count - 1) + " more)";
  if (result.code != QueryStatus::TF_UNAVAILABLE) return result;
  const std::string hint = hintFor(buffer, *lookup.robot, first->number);
  if (!hint.empty()) result.message += "; " + hint;
  return result;
}

/// The edges with the oldest and the newest transform. Static transforms are not considered.
struct CommonTime {
  const TfLookup::Edge* oldest = nullptr;
  const TfLookup::Edge* newest = nullptr;
};
CommonTime commonTime(const std::vector<TfLookup::Edge>& edges) {
  const auto stamp = [](const TfLookup::Edge* edge) { return edge->transform.stamp; };
  CommonTime common;
  for (const TfLookup::Edge& edge : edges) {
    if (!isAvailable(edge) || stamp(&edge).isZero()) continue;
    if (!common.oldest || stamp(&edge) < stamp(common.oldest)) common.oldest = &edge;
    if (!common.newest || stamp(&edge) > stamp(common.newest)) common.newest = &edge;
  }
  return common;
}

/// The limit on the age of transforms, with what is needed to explain an older one.
struct AgeLimit {
  const tf2::BufferCore& buffer;
  const FrameHealth& health;
  ros::Time now;
  ros::Duration max_age;
};

/// TF_STALE if the latest transform of an edge is too far from the clock, otherwise OK.
QueryStatus ageStatus(const EdgeTransform& latest, const TfEdge& edge, const AgeLimit& limit) {
  const ros::Duration age = elapsed(latest.stamp, limit.now);
  if (age > limit.max_age) {
    const std::string cause = limit.health.causeOf(limit.buffer, edge, limit.now);
    return statusOf(QueryStatus::TF_STALE, edge.name + ": its latest transform is " + durationText(age) +
                                               " old, max_tf_age is " + durationText(limit.max_age) +
                                               (cause.empty() ? "" : ": " + cause));
  }
  if (-age > limit.max_age) {
    return statusOf(QueryStatus::TF_STALE,
                    edge.name + ": its latest transform is " + durationText(-age) + " ahead of the clock");
  }
  return {};
}

QueryStatus ageStatus(const CommonTime& common, const AgeLimit& limit) {
  const QueryStatus of_oldest = ageStatus(common.oldest->transform, *common.oldest->frames, limit);
  if (of_oldest.code != QueryStatus::OK) return of_oldest;
  return ageStatus(common.newest->transform, *common.newest->frames, limit);
}

/// The transform at the time of the robot's poses. If tf does not have one at that time, the latest transform, which
/// must be near the clock.
EdgeTransform lookUpNearTime(const TfEdge& edge, const ros::Time& robot, const AgeLimit& limit) {
  EdgeTransform latest = lookUpEdge(limit.buffer, edge, ros::Time());
  if (!latest.pose || latest.stamp.isZero()) return latest;
  latest.status = ageStatus(latest, edge, limit);
  if (latest.status.code != QueryStatus::OK) {
    latest.pose.reset();
    return latest;
  }
  if (latest.stamp <= robot) return latest;
  const EdgeTransform then = lookUpEdge(limit.buffer, edge, robot);
  return then.pose ? then : latest;
}

std::optional<Eigen::Isometry3d> poseOfLink(const scene::RobotModel& robot, int link, const scene::BodyPoses& poses) {
  const scene::Link& asked = robot.links[link];
  const std::optional<Eigen::Isometry3d>& body = poses[asked.body];
  if (!body) return std::nullopt;
  return *body * asked.body_T_link;
}

}  // namespace

TfLookup::TfLookup(const Robot& asked, const std::vector<int>& numbers) : robot(&asked) {
  const std::vector<TfEdge>& all = *asked.tfEdges();
  for (const int edge : numbers) edges.push_back({edge, &all[edge], {}});
  joint_snapshot.joints.resize(asked.robotModel().joints.size());
  joint_snapshot.stated.resize(asked.robotModel().joints.size());
  joint_snapshot.roots.resize(asked.robotModel().robots.size());
}

std::vector<int> bodiesOf(const Robot& robot, const CarrierFrames& frames) {
  std::vector<int> bodies;
  for (const int index : frames.needed) {
    const int link = robot.linkOfFrame(frames.names[index]);
    if (link >= 0) bodies.push_back(robot.robotModel().links[link].body);
  }
  return bodies;
}

void placeFramesOfLinks(const Robot& robot, const CarrierFrames& frames, const scene::BodyPoses& poses,
                        scene::FramePoses& placed) {
  for (const int index : frames.needed) {
    const int link = robot.linkOfFrame(frames.names[index]);
    if (link >= 0) placed[index] = poseOfLink(robot.robotModel(), link, poses);
  }
}

void TfPoses::add(const tf2_msgs::TFMessage& message, TfTree::Kind kind, const std::string& publisher) {
  if (kind == TfTree::Kind::Moving) {
    for (const geometry_msgs::TransformStamped& transform : message.transforms)
      if (!transform.header.stamp.isZero()) jumps_.add(transform);
  }
  tree_.add(message, kind);
  if (kind == TfTree::Kind::Moving) health_.add(message, publisher, ros::Time::now());  // later: see causeOf()
  const std::lock_guard<std::mutex> lock(mutex_);
  ++changes_;
  changed_.notify_all();
  if (listener_) listener_();
}

std::vector<std::string> TfPoses::warnings(const Robot& robot, double rate) {
  const std::shared_ptr<const tf2::BufferCore> buffer = tree_.view().buffer;
  return health_.warnings(*buffer, robot, edgesTo(robot, robot.candidateBodies()), rate, ros::Time::now());
}

void TfPoses::onChange(std::function<void()> listener) {
  const std::lock_guard<std::mutex> lock(mutex_);
  listener_ = std::move(listener);
}

ros::Time TfPoses::readClock() {
  // Read under the lock: otherwise two threads could compare their times in the wrong order and see a jump back.
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time now = ros::Time::now();
  if (now < last_now_) {
    ROS_WARN_STREAM("the clock jumped back by " << durationText(elapsed(now, last_now_))
                                                << ": forgetting all transforms");
    tree_.clear();
    jumps_.forget();
    health_.forget();
  }
  last_now_ = now;
  return now;
}

const PoseSnapshot& TfPoses::lookUp(TfLookup& lookup, const ros::Time& stamp) {
  assignPoses(*lookup.robot, lookUpJoints(lookup, stamp), lookup.pose_snapshot);
  lookup.pose_snapshot.beyond = farthestBeyond(*lookup.robot, stated_, ros::Time::now());
  return lookup.pose_snapshot;
}

PoseSnapshot TfPoses::await(const Robot& robot, const std::vector<int>& bodies, const ros::Time& stamp,
                            std::optional<double> timeout) {
  PoseSnapshot snapshot;
  assignPoses(robot, awaitJoints(robot, edgesTo(robot, bodies), stamp, timeout), snapshot);
  return snapshot;
}

std::shared_ptr<const tf2::BufferCore> TfPoses::latestOf(const Robot& robot, std::vector<TfLookup::Edge>& edges) {
  const TfTree::View tf = tree_.view();
  latest_.find(tf, robot, edges);
  return tf.buffer;
}

const JointSnapshot& TfPoses::lookUpJoints(TfLookup& lookup, const ros::Time& stamp) {
  JointSnapshot& snapshot = lookup.joint_snapshot;
  std::vector<TfLookup::Edge>& edges = lookup.edges;
  clearSnapshot(stamp, snapshot);
  const ros::Time now = readClock();
  if (now.isZero()) {
    snapshot.status =
        statusOf(QueryStatus::TF_UNAVAILABLE, "waiting for the clock: use_sim_time is set, /clock is not");
    return snapshot;
  }

  const std::shared_ptr<const tf2::BufferCore> buffer = latestOf(*lookup.robot, edges);
  const CommonTime common = commonTime(edges);
  snapshot.status = summary(lookup, *buffer);
  if (!common.oldest && snapshot.status.code != QueryStatus::OK) return snapshot;
  // Static transforms hold at any time, so a robot that has only these gets the time of the clock.
  const ros::Time oldest = common.oldest ? common.oldest->transform.stamp : now;
  const ros::Time newest = common.newest ? common.newest->transform.stamp : now;
  if (common.oldest) snapshot.skew = elapsed(oldest, newest);

  snapshot.stamp = stamp.isZero() ? oldest : stamp;
  snapshot.age = elapsed(snapshot.stamp, now);
  if (stamp.isZero() && common.oldest) {
    const ros::Duration max_age(lookup.robot->config().max_tf_age);
    snapshot.status = ageStatus(common, {*buffer, health_, now, max_age});
    // A transform that is far ahead of the clock may be from before the clock jumped back. tf would then refuse all new
    // transforms, because they are older.
    if (elapsed(now, newest) > max_age) tree_.clear();
    if (snapshot.status.code != QueryStatus::OK) return snapshot;
  }
  for (TfLookup::Edge& edge : edges) {
    if (isAvailable(edge) && edge.transform.stamp != snapshot.stamp) {
      edge.transform = lookUpEdge(*buffer, *edge.frames, snapshot.stamp);
    }
  }
  snapshot.status = summary(lookup, *buffer);
  copyTransforms(lookup);
  findTurns(stated_.view(), lookup);
  return snapshot;
}

template <class LookUp>
auto TfPoses::await(double timeout, LookUp look_up) {
  // The deadline is in wall time, because a simulated clock may stand still.
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout);
  while (true) {
    const std::uint64_t seen = changes_;
    const auto snapshot = look_up();
    if (snapshot.status.code == QueryStatus::OK) return snapshot;
    const RequestWait request_wait;
    std::unique_lock<std::mutex> lock(mutex_);
    // The deadline is also checked after a change, so that the wait ends even if changes come all the time.
    const bool changed = changed_.wait_until(lock, deadline, [&] { return changes_ != seen; });
    if (!changed || std::chrono::steady_clock::now() >= deadline) return snapshot;
  }
}

JointSnapshot TfPoses::awaitJoints(const Robot& robot, const std::vector<int>& edges, const ros::Time& stamp,
                                   std::optional<double> timeout) {
  TfLookup lookup(robot, edges);
  return await(timeout.value_or(robot.config().tf_timeout), [&] { return lookUpJoints(lookup, stamp); });
}

QueryStatus TfPoses::standingStill(const Robot& robot, const std::vector<int>& robots) {
  const std::vector<int> roots = robot.robotModel().roots();
  const auto frame = [&](int member) {
    return member == kReferenceFrame ? robot.referenceFrame()
                                     : robot.frameOf(robot.robotModel().bodies[roots[member]].link);
  };
  const std::shared_ptr<const tf2::BufferCore> buffer = tree_.view().buffer;
  for (std::size_t i = 1; i < robots.size(); ++i) {
    const TfEdge edge{frame(robots.front()), frame(robots[i]), ""};
    const EdgeTransform found = lookUpEdge(*buffer, edge, ros::Time());
    if (found.pose && found.stamp.isZero()) continue;
    const std::string& name = robot.sources()[robots[i]].name;
    return statusOf(QueryStatus::NO_VELOCITY, (name.empty() ? "the robot" : "robot '" + name + "'") + ": its base '" +
                                                  edge.child + "' may move against '" + edge.parent +
                                                  "', as /tf_static does not join them");
  }
  return {};
}

FrameSnapshot TfPoses::lookUpFrames(const Robot& robot, const CarrierFrames& frames, const PoseSnapshot& robot_poses,
                                    const ros::Time& stamp) {
  FrameSnapshot snapshot;
  snapshot.poses.resize(frames.names.size());
  if (frames.needed.empty()) return snapshot;
  if (robot_poses.stamp.isZero()) {
    snapshot.status = robot_poses.status;
    return snapshot;
  }
  const ros::Time now = readClock();
  const std::shared_ptr<const tf2::BufferCore> buffer = tree_.view().buffer;
  const AgeLimit limit{*buffer, health_, now, ros::Duration(robot.config().max_tf_age)};
  for (const int index : frames.needed) {
    const std::string& frame = frames.names[index];
    if (robot.linkOfFrame(frame) >= 0) continue;
    const TfEdge edge{robot.referenceFrame(), frame, "frame '" + frame + "'"};
    const EdgeTransform found =
        stamp.isZero() ? lookUpNearTime(edge, robot_poses.stamp, limit) : lookUpEdge(*buffer, edge, stamp);
    snapshot.poses[index] = found.pose;
    if (!found.stamp.isZero()) snapshot.may_move.push_back(index);
    if (!found.pose && snapshot.status.code == QueryStatus::OK) snapshot.status = found.status;
  }
  placeFramesOfLinks(robot, frames, robot_poses.poses, snapshot.poses);
  return snapshot;
}

FrameSnapshot TfPoses::awaitFrames(const Robot& robot, const CarrierFrames& frames, const PoseSnapshot& robot_poses,
                                   const ros::Time& stamp, std::optional<double> timeout) {
  if (robot_poses.status.code != QueryStatus::OK) return lookUpFrames(robot, frames, robot_poses, stamp);
  return await(timeout.value_or(robot.config().tf_timeout),
               [&] { return lookUpFrames(robot, frames, robot_poses, stamp); });
}

}  // namespace proximity_server::node
