#include "node/monitor/commanded_trajectories.h"

#include "node/services/joint_requests.h"
#include "node/services/trajectory_requests.h"
#include "proximity_server/QueryTrajectoryRequest.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/model/posed_position.h"
#include "system/number_text.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <iomanip>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

using Lock = std::lock_guard<std::mutex>;
using scene::SplineDelays;

constexpr double kWholeTurn = 2.0 * 3.14159265358979323846;
constexpr std::size_t kMostWaiting = 100;
constexpr std::ptrdiff_t kMostReplaced = 4;
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kResolutionOfTime = 1e-9;  // [s] that of stamps; differences of times have smaller errors

bool turns(const scene::Joint& joint) {
  return scene::hasOnePosition(joint) && joint.type != scene::Joint::Type::Prismatic;
}

bool contains(const std::vector<int>& joints, int joint) {
  return std::find(joints.begin(), joints.end(), joint) != joints.end();
}

bool share(const std::vector<int>& a, const std::vector<int>& b) {
  return std::any_of(a.begin(), a.end(), [&](int joint) { return contains(b, joint); });
}

void removeFrom(std::vector<int>& joints, const std::vector<int>& removed) {
  joints.erase(std::remove_if(joints.begin(), joints.end(), [&](int joint) { return contains(removed, joint); }),
               joints.end());
}

/// Returns whether joint_states tell the turn of a joint.
bool isTold(const PoseSnapshot& poses, int joint) { return !poses.stated.empty() && poses.stated[joint]; }

/// The position of a joint at the poses, on the turn that joint_states tell.
std::optional<double> positionOf(const scene::RobotModel& robot, const PoseSnapshot& poses, int joint) {
  if (isTold(poses, joint)) return poses.stated[joint];
  const std::optional<scene::PosedPosition> position = scene::posedPosition(robot, poses.poses, joint);
  return position ? std::optional<double>(position->value) : std::nullopt;
}

/// The joint that has the given index among those whose positions are known.
int knownJoint(const std::vector<int>& joints, const JointValues& positions, std::size_t index) {
  auto joint = joints.begin();
  for (;; ++joint)
    if (positions[*joint] && index-- == 0) return *joint;
}

bool hasPoints(const CommandedSplines& splines) { return splines.exact_from < kNever; }

/// How far the splines of a command may be off until its first point, as they go on from the state at its begin, which
/// may be that of a time up to `reach` [s] earlier or later. Other positions, velocities and accelerations at its start
/// change a polynomial by at most 1, 0.1976 and 0.0173 of them, in its time; `point` tells which of them it has.
/// The way in the time `reach` is bounded by the largest speed. Velocities and accelerations are sampled, h = reach / 4
/// apart, so that the largest sample is no bound: with an acceleration a, a velocity between two samples may be larger
/// by a h / 2. That moves a spline of 1 s by 0.01 rad at 10 rad/s^2 and the largest reach, 0.04 s.
std::vector<double> errorsOfStart(const CommandedSplines& before, const scene::SplineSegment& first,
                                  const scene::TrajectoryPoint& point, double reach) {
  const double begin = first.begin(), duration = first.end() - begin;
  const scene::TrajectoryPoint start = before.stateAt(begin);
  scene::Positions positions(start.positions.size(), 0.0), velocities = positions, accelerations = positions;
  for (int i = -4; i <= 4; ++i) {
    const scene::TrajectoryPoint state = before.stateAt(begin + 0.25 * i * reach);
    for (std::size_t j = 0; j < positions.size(); ++j) {
      velocities[j] = std::max(velocities[j], std::abs(state.velocities[j] - start.velocities[j]));
      accelerations[j] = std::max(accelerations[j], std::abs(state.accelerations[j] - start.accelerations[j]));
    }
  }
  for (std::size_t joint = 0; joint < positions.size(); ++joint) {
    positions[joint] = reach * before.largestSpeed(static_cast<int>(joint), begin - reach, begin + reach);
    if (!point.velocities.empty()) positions[joint] += 0.2 * duration * velocities[joint];
    if (!point.accelerations.empty()) positions[joint] += 0.018 * duration * duration * accelerations[joint];
  }
  return positions;
}

/// The name in the model of a joint that may be named as in its URDF. `member`: its robot, or -1 if it may be any.
std::string nameInModel(const scene::RobotModel& model, int member, const std::string& name) {
  if (scene::findNamed(model.joints, name) >= 0) return name;
  if (member >= 0) return model.robots[member].nameInModel(name);
  std::string found = name;
  for (const scene::Member& robot : model.robots) {
    const std::string whole = robot.nameInModel(name);
    if (scene::findNamed(model.joints, whole) < 0) continue;
    if (found != name)
      refuse("joint '" + name + "' may be '" + found + "' or '" + whole + "': name the topic in robots/" + robot.name +
             "/trajectories");
    found = whole;
  }
  return found;
}

WayPoints wayPointsOf(const Robot& robot, int member, trajectory_msgs::JointTrajectory message) {
  for (std::string& name : message.joint_names) name = nameInModel(robot.robotModel(), member, name);
  WayPoints way = wayPointsOf(robot, message, QueryTrajectoryRequest::QUINTIC);
  if (way.joints.empty() && !way.points.empty()) refuse("the trajectory names no joints");
  return way;
}

}  // namespace

// --- commands

void CommandedTrajectories::listen(ros::NodeHandle nh, const std::shared_ptr<const Robot>& robot) {
  std::map<std::string, int> topics;
  const auto add = [&](const std::vector<std::string>& names, int member) {
    for (const std::string& name : names)
      if (const auto [known, is_new] = topics.emplace(nh.resolveName(name), member); !is_new) known->second = -1;
  };
  for (std::size_t i = 0; i < robot->sources().size(); ++i) add(robot->sources()[i].trajectories, static_cast<int>(i));
  if (!robot->config().robots.empty()) add(robot->config().trajectories, -1);
  follow(robot, topics);
  for (auto known = subscribers_.begin(); known != subscribers_.end();)
    known = topics.count(known->first) ? std::next(known) : subscribers_.erase(known);
  for (const auto& topic : topics) {
    const std::string& name = topic.first;
    if (subscribers_.count(name)) continue;
    const bool is_action = name.size() > 5 && name.compare(name.size() - 5, 5, "/goal") == 0;
    std::vector<ros::Subscriber>& added = subscribers_[name];
    if (is_action) {
      const std::string cancel = name.substr(0, name.size() - 4) + "cancel";
      added.push_back(
          subscribed<TrajectoryActionGoal>(nh, name, name, [](const auto& goal) { return goal.trajectory; }));
      added.push_back(subscribed<TrajectoryActionCancel>(
          nh, cancel, name, [](const auto&) { return trajectory_msgs::JointTrajectory(); }));
    } else {
      added.push_back(
          subscribed<trajectory_msgs::JointTrajectory>(nh, name, name, [](const auto& message) { return message; }));
    }
  }
}

/// Makes commands of the topic `name` of what comes on a topic. The command comes when its message does, not when this
/// node finds the time for it.
template <class Message, class TrajectoryOf>
ros::Subscriber CommandedTrajectories::subscribed(ros::NodeHandle& nh, const std::string& topic,
                                                  const std::string& name, const TrajectoryOf& trajectoryOf) {
  using Event = ros::MessageEvent<const Message>;
  return nh.subscribe<Message, const Event&>(topic, 10, [this, name, trajectoryOf](const Event& event) {
    const std::string problem = take(name, trajectoryOf(*event.getConstMessage()), event.getReceiptTime());
    if (!problem.empty()) ROS_WARN_STREAM_THROTTLE(10.0, name << ": " << problem << "; the trajectory before is kept");
  });
}

void CommandedTrajectories::stopListening() {
  subscribers_.clear();
  follow(nullptr, {});
}

void CommandedTrajectories::follow(const std::shared_ptr<const Robot>& robot,
                                   const std::map<std::string, int>& topics) {
  const Lock lock(mutex_);
  topics_ = topics;
  if (robot == robot_) return;
  robot_ = robot;
  forget();
}

void CommandedTrajectories::forget() {
  waiting_.clear();
  driven_.clear();
  last_now_ = {};
  last_begun_ = last_number_;
}

/// [s] Computed in double, because ros::Duration throws for stamps that are decades apart.
double CommandedTrajectories::secondsAt(const ros::Time& time) const {
  return (static_cast<double>(time.sec) - static_cast<double>(epoch_.sec)) +
         1e-9 * (static_cast<double>(time.nsec) - static_cast<double>(epoch_.nsec));
}

std::string CommandedTrajectories::take(const std::string& topic, const trajectory_msgs::JointTrajectory& message,
                                        const ros::Time& now) {
  std::shared_ptr<const Robot> robot;
  int member;
  {
    const Lock lock(mutex_);
    const auto known = topics_.find(topic);
    if (known == topics_.end()) return {};
    robot = robot_;
    member = known->second;
  }
  try {
    WayPoints way = wayPointsOf(*robot, member, message);
    const Lock lock(mutex_);
    if (robot_ == robot) await({topic, std::move(way.joints), std::move(way.points)}, message.header.stamp, now);
  } catch (const RequestError& error) {
    return error.what();
  }
  return {};
}

/// Keeps a command until it begins. It replaces those of its joints that do not begin before it; of too many those that
/// do, too.
void CommandedTrajectories::await(Command command, const ros::Time& stamp, const ros::Time& now) {
  if (waiting_.empty() && driven_.empty()) epoch_ = now;
  const double received = command.received = secondsAt(now);
  command.zero = stamp.isZero() ? received : secondsAt(stamp);
  command.begin = command.points.empty() ? received : std::max(command.zero, received);
  command.begin_error = command.begin > received ? 0.0 : SplineDelays::kLargestLead;
  command.least_delay = stamp.isZero() ? -SplineDelays::kLargestLead : 0.0;
  command.number = ++last_number_;
  const auto is_replaced = [&](const Command& other) {
    if (command.joints.empty()) return other.topic == command.topic;
    return (other.begin >= command.begin || waiting_.size() >= kMostWaiting) &&
           std::all_of(other.joints.begin(), other.joints.end(),
                       [&](int joint) { return contains(command.joints, joint); });
  };
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), is_replaced), waiting_.end());
  if (waiting_.size() >= kMostWaiting) refuse("too many trajectories wait until they begin");
  waiting_.push_back(std::move(command));
}

// --- the motion

const CommandedMotion& CommandedTrajectories::lookUp(const std::vector<int>& joints, const PoseSnapshot& poses,
                                                     const VelocitySnapshot& velocities, const ros::Time& now) {
  const Lock lock(mutex_);
  motion_.positions.clear();
  motion_.text.clear();
  if (now < last_now_) forget();
  last_now_ = now;
  const bool is_known = poses.status.code == QueryStatus::OK && velocities.status.code == QueryStatus::OK;
  if ((waiting_.empty() && driven_.empty()) || !is_known) {
    motion_.followed.clear();
    return motion_;
  }

  positions_.assign(velocities.velocities.size(), std::nullopt);
  for (const int joint : joints) positions_[joint] = positionOf(robot_->robotModel(), poses, joint);
  const Present present{secondsAt(poses.stamp), secondsAt(now), positions_, poses, velocities};
  for (Driven& driven : driven_) track(driven, present);
  for (const Command& command : waiting_)
    if (mustBegin(command)) begin(command, present);
  const auto has_begun = [&](const Command& command) { return command.begin <= present.now; };
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), has_begun), waiting_.end());
  forgetDriven(present);
  findMotion(present);
  return motion_;
}

/// Forgets what is over, and what was replaced by a command that the robot has agreed with since, or has left.
void CommandedTrajectories::forgetDriven(const Present& present) {
  for (const Driven& driven : driven_)
    if (agreesSince(driven, driven.begin, present))
      for (Driven& before : driven_)
        if (&before < &driven) removeFrom(before.joints, driven.joints);
  const auto is_gone = [&](const Driven& driven) {
    const bool has_left = !driven.delays.fits();
    return driven.joints.empty() || (has_left && driven.replaced < kNever) ||
           (isOver(driven, present) && (has_left || !hasPoints(*driven.splines)));
  };
  driven_.erase(std::remove_if(driven_.begin(), driven_.end(), is_gone), driven_.end());
}

/// Returns whether the last point has passed, with each possible delay.
bool CommandedTrajectories::isOver(const Driven& driven, const Present& present) {
  return present.time - driven.delays.most() >= driven.splines->segments.back().end();
}

/// Returns whether the robot has agreed with splines for long enough after a time, with each possible delay.
bool CommandedTrajectories::agreesSince(const Driven& driven, double time, const Present& present) {
  const double passed = present.time - driven.delays.most() - time;
  return driven.delays.areFollowed() && passed >= SplineDelays::kAgreement;
}

/// Returns whether joints follow splines: since they were replaced, if they were.
bool CommandedTrajectories::isSure(const Driven& driven, const Present& present) {
  if (driven.replaced < kNever) return agreesSince(driven, driven.replaced, present);
  return driven.is_inherited ? driven.delays.areFollowed() : agreesSince(driven, driven.begin, present);
}

/// Returns whether a command has no splines yet, or waits while the robot has left them.
bool CommandedTrajectories::mustBegin(const Command& command) const {
  const auto is_left = [&](const Driven& driven) {
    return driven.number == command.number && driven.replaced == kNever && !driven.delays.fits();
  };
  return command.number > last_begun_ || std::any_of(driven_.begin(), driven_.end(), is_left);
}

void CommandedTrajectories::begin(const Command& command, const Present& present) {
  const bool is_again = command.number <= last_begun_;
  last_begun_ = std::max(last_begun_, command.number);
  const auto is_moved = [&](const Driven& driven, int joint) {
    if (is_again && (driven.number != command.number || driven.delays.fits())) return false;
    return command.joints.empty() ? driven.splines->topic == command.topic : contains(command.joints, joint);
  };
  std::vector<Driven> next;
  std::vector<int> others = command.joints, continuing;
  try {
    for (auto place = driven_.rbegin(); place != driven_.rend(); ++place) {
      const Driven& before = *place;
      if (before.number == command.number && before.delays.fits()) removeFrom(others, before.joints);
      std::vector<int> joints;
      std::copy_if(before.joints.begin(), before.joints.end(), std::back_inserter(joints),
                   [&](int joint) { return is_moved(before, joint) && !contains(continuing, joint); });
      const bool is_current = before.replaced == kNever || agreesSince(before, before.replaced, present);
      if (joints.empty() || !is_current || !goesOn(command, before)) continue;
      Driven driven = continued(command, before, std::move(joints));
      if (driven.splines->segments.empty()) continue;  // a rest has ended
      track(driven, present);
      if (!driven.delays.fits()) continue;                             // the robot had left what was commanded before
      if (isSure(before, present)) removeFrom(others, driven.joints);  // else they may begin where they are
      continuing.insert(continuing.end(), driven.joints.begin(), driven.joints.end());
      next.push_back(std::move(driven));
    }
    if (!others.empty() && !command.points.empty()) next.push_back(begun(command, std::move(others), present));
  } catch (const std::invalid_argument& error) {
    ROS_WARN_STREAM_THROTTLE(10.0, command.topic << ": " << error.what() << "; the trajectory before is kept");
    return;
  }
  replaceBy(command, is_moved);
  std::move(next.begin(), next.end(), std::back_inserter(driven_));
  for (Driven& driven : driven_) track(driven, present);  // by the joints that it has now
}

/// Keeps what joints followed before a command, too, because the controller may refuse it.
template <class IsMoved>
void CommandedTrajectories::replaceBy(const Command& command, const IsMoved& isMoved) {
  std::vector<Driven> kept;
  for (Driven& driven : driven_) {
    std::vector<int>& joints = driven.joints;
    const auto first_moved =
        std::stable_partition(joints.begin(), joints.end(), [&](int joint) { return !isMoved(driven, joint); });
    Driven replaced = driven;
    replaced.joints.assign(first_moved, joints.end());
    replaced.replaced = command.begin;
    joints.erase(first_moved, joints.end());
    if (!replaced.joints.empty() && replaced.delays.fits()) kept.push_back(std::move(replaced));
    if (!joints.empty()) kept.push_back(std::move(driven));
  }
  const auto is_replaced = [](const Driven& driven) { return driven.replaced < kNever; };
  while (std::count_if(kept.begin(), kept.end(), is_replaced) > kMostReplaced)
    kept.erase(std::find_if(kept.begin(), kept.end(), is_replaced));
  driven_ = std::move(kept);
}

/// Returns whether a command goes on from what was commanded until then. The robot is there, or was until it began to
/// follow the command, which this node may have received late: not if it had left before.
bool CommandedTrajectories::goesOn(const Command& command, const Driven& before) {
  return before.delays.fits() || before.delays.leftAt() >= command.begin - SplineDelays::kLargestLead;
}

/// The splines before, until the command begins, and then its own. Without points, they end there.
CommandedTrajectories::Driven CommandedTrajectories::continued(const Command& command, const Driven& before,
                                                               std::vector<int> joints) const {
  const CommandedSplines& old = *before.splines;
  const double reach = command.begin_error + old.begin_error;
  const double until = command.points.empty() ? command.begin + reach : command.begin;
  const double earliest = command.received - SplineDelays::kLargest - robot_->config().max_tf_age;
  CommandedSplines splines;
  splines.topic = command.topic;
  splines.begin_error = command.begin_error;
  splines.exact_from = kNever;
  for (const scene::SplineSegment& segment : old.segments) {
    if (segment.end() < earliest || segment.begin() > until - kResolutionOfTime) continue;
    const double part = (until - segment.begin()) / (segment.end() - segment.begin());
    splines.segments.push_back(part < 1.0 ? segment.between(0.0, part) : segment);
  }
  const std::size_t count = splines.segments.size();
  std::vector<double>& errors = splines.inexact_before;
  errors.assign(robot_->robotModel().joints.size(), 0.0);
  double slack = reach;
  if (command.points.empty()) {
    slack += SplineDelays::kLargest;  // it may have stopped anywhere on the way to the end
  } else {
    addPoints(command, old.stateAt(command.begin), splines);
    splines.exact_from = splines.segments[count].end();
    errors =
        errorsOfStart(old, splines.segments[count], *firstPoint(command, command.begin + kResolutionOfTime), reach);
  }
  for (const int joint : joints) {
    errors[joint] = std::max(errors[joint], slack * old.largestSpeed(joint, earliest, until + reach));
    errors[joint] += old.inexactAt(joint, earliest);
    // At a stamp that is past, the way to the first point takes more or less time, by the error of its begin.
    if (command.least_delay == 0.0 && !command.points.empty())
      errors[joint] += 1.5 * command.begin_error * splines.segments[count].largestSpeed(joint);
  }
  const bool is_same = joints.size() == before.joints.size() && command.topic == old.topic && !command.points.empty();
  const double since = is_same && before.delays.fits() ? before.delays.agreedSince() : kNever;
  return {std::make_shared<const CommandedSplines>(std::move(splines)),
          std::move(joints),
          SplineDelays(command.least_delay, since),
          command.number,
          command.begin,
          since < kNever};
}

/// The way from the present state to that at the begin, and then the splines of the command. The joints may have been
/// commanded to rest where they are, within the tracking error.
CommandedTrajectories::Driven CommandedTrajectories::begun(const Command& command, std::vector<int> joints,
                                                           const Present& present) const {
  const double begin = std::max(command.begin, present.time);
  CommandedSplines splines;
  splines.topic = command.topic;
  splines.begin_error = command.begin_error;
  splines.exact_from = begin;
  scene::TrajectoryPoint start = presentState(command, present, begin);
  if (present.time < begin - kResolutionOfTime)
    splines.segments.emplace_back(robot_->robotModel(), presentState(command, present, present.time), start);
  const std::size_t count = splines.segments.size();
  addPoints(command, std::move(start), splines);
  splines.exact_from = splines.segments[count].end();
  splines.inexact_before.assign(robot_->robotModel().joints.size(), 0.0);
  for (const int joint : joints)
    splines.inexact_before[joint] =
        allowed(joint) + command.begin_error * std::abs(present.velocities.velocities[joint]);
  return {std::make_shared<const CommandedSplines>(std::move(splines)),
          std::move(joints),
          SplineDelays(command.least_delay),
          command.number,
          command.begin,
          false};
}

/// The first point of a command from a time on.
auto CommandedTrajectories::firstPoint(const Command& command, double time) -> Points::const_iterator {
  return std::find_if(command.points.begin(), command.points.end(),
                      [&](const scene::TrajectoryPoint& point) { return command.zero + point.time >= time; });
}

/// Adds the splines of a command from a state on.
void CommandedTrajectories::addPoints(const Command& command, scene::TrajectoryPoint start,
                                      CommandedSplines& splines) const {
  const scene::RobotModel& robot = robot_->robotModel();
  const double begin = start.time;
  std::vector<scene::TrajectoryPoint> points(firstPoint(command, begin + kResolutionOfTime), command.points.end());
  for (scene::TrajectoryPoint& point : points) point.time += command.zero - begin;
  points = scene::drivenFrom(robot, std::move(start), points);
  for (scene::TrajectoryPoint& point : points) point.time += begin;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) splines.segments.emplace_back(robot, points[i], points[i + 1]);
  findBeyond(command.joints, splines);
}

void CommandedTrajectories::findBeyond(const std::vector<int>& joints, CommandedSplines& splines) const {
  const scene::RobotModel& robot = robot_->robotModel();
  for (const scene::SplineSegment& segment : splines.segments) {
    for (const scene::SplineSegment::Excess& excess : segment.beyondLimits(robot)) {
      if (!contains(joints, excess.joint) || std::abs(excess.position - excess.limit) <= kWritingError) continue;
      std::ostringstream text;
      text << std::setprecision(6) << "joint '" << robot.joints[excess.joint].name << "' goes to " << excess.position
           << ", and its " << (excess.position < excess.limit ? "lower" : "upper") << " limit is " << excess.limit;
      splines.beyond.push_back({segment.timeAt(excess.time), text.str()});
    }
  }
}

/// The state at a time if the joints of a command keep their present velocities until then. Before a command that
/// begins later than now they rest.
scene::TrajectoryPoint CommandedTrajectories::presentState(const Command& command, const Present& present,
                                                           double time) const {
  const auto first = firstPoint(command, time);
  const scene::Positions none(present.positions.size(), 0.0);
  scene::TrajectoryPoint state{time, first == command.points.end() ? none : first->positions, none, none};
  for (const int joint : command.joints) {
    if (!present.positions[joint]) continue;
    double position = *present.positions[joint];
    if (!isTold(present.poses, joint))
      position = onTurnNearestTo(state.positions[joint], position, robot_->robotModel().joints[joint]);
    if (command.begin <= present.now) state.velocities[joint] = present.velocities.velocities[joint];
    state.positions[joint] = position + state.velocities[joint] * (time - present.time);
  }
  return state;
}

/// Finds the delays with which the robot may follow the splines.
void CommandedTrajectories::track(Driven& driven, const Present& present) {
  measured_.clear();
  for (const int joint : driven.joints) {
    if (!present.positions[joint]) continue;
    const double commanded = driven.splines->positionAt(joint, present.time);
    measured_.push_back({commanded + offBy(joint, *present.positions[joint], commanded),
                         present.velocities.velocities[joint],
                         secondsAt(present.velocities.stamps[joint]) - present.time,
                         allowed(joint) + driven.splines->inexactAt(joint, present.time - SplineDelays::kLargest),
                         robot_->trackingVelocityErrors()[joint].value_or(0.0)});
  }
  // Captures no more than std::function keeps without allocating.
  const auto positionAt = [&driven, &present](std::size_t joint, double delay) {
    return driven.splines->positionAt(knownJoint(driven.joints, present.positions, joint), present.time - delay);
  };
  driven.delays.observe(present.time, measured_, positionAt);
}

/// [rad] or [m] Positions of joints that turn are equal after a whole turn.
double CommandedTrajectories::offBy(int joint, double position, double commanded) const {
  const double off = position - commanded;
  return turns(robot_->robotModel().joints[joint]) ? std::remainder(off, kWholeTurn) : off;
}

/// [rad] or [m]
double CommandedTrajectories::allowed(int joint) const {
  return robot_->trackingErrors()[joint].value_or(0.0) + kResolution;
}

/// "joint 'elbow' is 0.12 rad off the trajectory of /arm: velocities are taken"
std::string CommandedTrajectories::textOfStray(const Driven& driven) const {
  const int stray = knownJoint(driven.joints, positions_, driven.delays.farthestJoint());
  const scene::Joint& joint = robot_->robotModel().joints[stray];
  std::ostringstream text;
  text << std::setprecision(3) << "joint '" << joint.name << "' is " << driven.delays.farthest()
       << (turns(joint) ? " rad" : " m") << " off the trajectory of " << driven.splines->topic
       << ": velocities are taken";
  return text.str();
}

void CommandedTrajectories::findMotion(const Present& present) {
  std::string strays;
  std::size_t followed = 0;
  for (const Driven& driven : driven_) {
    if (isOver(driven, present)) continue;
    if (motion_.positions.empty()) {
      for (const std::optional<double>& position : present.positions)
        motion_.positions.push_back(position.value_or(0.0));
      motion_.tracking_error.assign(present.positions.size(), 0.0);
    }
    if (driven.delays.fits()) {
      if (followed == motion_.followed.size()) motion_.followed.emplace_back();
      if (follow(driven, present, motion_.followed[followed])) ++followed;
    } else if (hasPoints(*driven.splines) && !fitsBeside(driven, [](const Driven&) { return true; }))
      strays += (strays.empty() ? "" : "; ") + textOfStray(driven);
  }
  motion_.followed.resize(followed);
  if (!strays.empty()) motion_.text += (motion_.text.empty() ? "" : "; ") + strays;
}

/// Returns whether a joint is on other splines, too, that are as asked.
template <class Test>
bool CommandedTrajectories::fitsBeside(const Driven& driven, const Test& isAsked) const {
  return std::any_of(driven_.begin(), driven_.end(), [&](const Driven& other) {
    return &other != &driven && other.delays.fits() && share(other.joints, driven.joints) && isAsked(other);
  });
}

/// Finds the joints that may follow splines, and which splines these are. Earlier ones of the same joints are those that
/// count if a command was refused; if these are over, the joints rest. Returns whether there is such a joint.
bool CommandedTrajectories::follow(const Driven& driven, const Present& present, scene::FollowedSplines& followed) {
  using Certainty = scene::FollowedSplines::Certainty;
  const SplineDelays& delays = driven.delays;
  const auto isLater = [&](const Driven& other) { return &other > &driven && !isOver(other, present); };
  const auto isEarlier = [&](const Driven& other) { return &other < &driven && !isOver(other, present); };
  const auto rests = [&](const Driven& other) { return &other < &driven && isOver(other, present); };
  const bool is_sure = isSure(driven, present) && !fitsBeside(driven, isLater) && !fitsBeside(driven, rests);
  followed.splines = driven.splines;
  followed.joints.clear();
  followed.time = present.time - delays.best();
  followed.behind = delays.most() - delays.best();
  followed.ahead = delays.best() - delays.least();
  followed.certainty = is_sure ? Certainty::Followed : Certainty::PerhapsFollowed;
  for (const int joint : driven.joints) {
    if (!present.positions[joint]) continue;
    followed.joints.push_back(joint);
    const double position = driven.splines->positionAt(joint, followed.time);
    motion_.positions[joint] = position + offBy(joint, *present.positions[joint], position);
    motion_.tracking_error[joint] = allowed(joint);
  }
  if (followed.joints.empty()) return false;
  const auto hides = [&](const Driven& other) { return isLater(other) && hasPoints(*other.splines); };
  if (!hasPoints(*driven.splines) || fitsBeside(driven, hides)) return true;
  std::string& text = motion_.text;
  text += text.empty() ? "along the trajectory of " : " and of ";
  text += driven.splines->topic;
  if (fitsBeside(driven, isEarlier)) text += " or the one before it";
  if (!is_sure) text += " or with the velocities";
  text += ", with a delay of ";
  system::appendRounded(text, delays.best(), 3);
  text += " s";
  const auto& beyond = driven.splines->beyond;
  const auto next = std::find_if(beyond.begin(), beyond.end(),
                                 [&](const CommandedSplines::Excess& excess) { return excess.time >= followed.time; });
  if (next == beyond.end()) return true;
  text += ", where in ";
  system::appendRounded(text, next->time - followed.time, 3);
  text += " s " + next->text;
  return true;
}

}  // namespace proximity_server::node
