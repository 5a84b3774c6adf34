#include "node/monitor/commanded_trajectories.h"

#include "node/services/joint_requests.h"
#include "node/services/trajectory_requests.h"
#include "proximity_server/QueryTrajectoryRequest.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/model/posed_position.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <iomanip>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace proximity_server::node {
namespace {

using Lock = std::lock_guard<std::mutex>;

constexpr double kWholeTurn = 2.0 * 3.14159265358979323846;
constexpr std::size_t kMostWaiting = 100;
constexpr double kResolutionOfTime = 1e-9;  // [s] that of stamps; differences of times have smaller errors
/// A delay of 0.1 s counts as much as an error of 1 mrad, so that noise at rest is not taken for a delay.
constexpr double kPriceOfDelay = 0.01;

bool turns(const scene::Joint& joint) {
  return scene::hasOnePosition(joint) && joint.type != scene::Joint::Type::Prismatic;
}

double squared(double x) { return x * x; }

bool contains(const std::vector<int>& joints, int joint) {
  return std::find(joints.begin(), joints.end(), joint) != joints.end();
}

/// The position of a joint at the poses, on the turn that joint_states tell; without its pose that of joint_states.
std::optional<double> positionOf(const scene::RobotModel& robot, const scene::BodyPoses& poses,
                                 const VelocitySnapshot& velocities, int joint) {
  const std::optional<scene::PosedPosition> position = scene::posedPosition(robot, poses, joint);
  const std::optional<double>& stated = velocities.positions[joint];
  if (!position) return stated;
  return stated && position->spacing > 0.0 ? position->nearestTo(*stated) : position->value;
}

/// The segment of a time, and this time on the segment: before 0 or after 1 if it belongs to none.
std::pair<const scene::SplineSegment*, double> placeOf(const CommandedSplines& splines, double time) {
  const auto is_later = [](double t, const scene::SplineSegment& segment) { return t < segment.begin(); };
  const auto next = std::upper_bound(splines.segments.begin() + 1, splines.segments.end(), time, is_later);
  const scene::SplineSegment& segment = *std::prev(next);
  return {&segment, (time - segment.begin()) / (segment.end() - segment.begin())};
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

scene::TrajectoryPoint CommandedSplines::stateAt(double time) const {
  const auto [segment, place] = placeOf(*this, time);
  scene::TrajectoryPoint state = segment->stateAt(std::clamp(place, 0.0, 1.0));
  if (place >= 0.0 && place <= 1.0) return state;
  std::fill(state.velocities.begin(), state.velocities.end(), 0.0);
  std::fill(state.accelerations.begin(), state.accelerations.end(), 0.0);
  return state;
}

scene::SplineSegment CommandedSplines::between(double from, double to) const {
  const scene::SplineSegment& segment = *placeOf(*this, 0.5 * (from + to)).first;
  const auto place = [&](double time) {
    return std::clamp((time - segment.begin()) / (segment.end() - segment.begin()), 0.0, 1.0);
  };
  return segment.between(place(from), place(to));
}

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
  const auto onTrajectory = [this](const std::string& topic, const trajectory_msgs::JointTrajectory& trajectory) {
    const std::string problem = take(topic, trajectory, ros::Time::now());
    if (!problem.empty()) ROS_WARN_STREAM_THROTTLE(10.0, topic << ": " << problem << "; the trajectory before is kept");
  };
  for (const auto& topic : topics) {
    const std::string& name = topic.first;
    if (subscribers_.count(name)) continue;
    const bool is_action = name.size() > 5 && name.compare(name.size() - 5, 5, "/goal") == 0;
    if (is_action)
      subscribers_[name] = nh.subscribe<TrajectoryActionGoal>(
          name, 10,
          [=](const boost::shared_ptr<const TrajectoryActionGoal>& goal) { onTrajectory(name, goal->trajectory); });
    else
      subscribers_[name] = nh.subscribe<trajectory_msgs::JointTrajectory>(
          name, 10,
          [=](const trajectory_msgs::JointTrajectory::ConstPtr& trajectory) { onTrajectory(name, *trajectory); });
  }
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

/// Keeps a command until it begins. It replaces those of its joints that do not begin before it. If it begins at once,
/// it replaces those that no cycle has seen yet, too.
void CommandedTrajectories::await(Command command, const ros::Time& stamp, const ros::Time& now) {
  if (waiting_.empty() && driven_.empty()) epoch_ = now;
  const double received = secondsAt(now);
  command.zero = stamp.isZero() ? received : secondsAt(stamp);
  command.begin = command.points.empty() ? received : std::max(command.zero, received);
  const auto is_replaced = [&](const Command& other) {
    if (command.joints.empty()) return other.topic == command.topic;
    return (other.begin >= command.begin || command.begin <= received) &&
           std::all_of(other.joints.begin(), other.joints.end(),
                       [&](int joint) { return contains(command.joints, joint); });
  };
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), is_replaced), waiting_.end());
  if (waiting_.size() >= kMostWaiting) refuse("too many trajectories wait until they begin");
  waiting_.push_back(std::move(command));
}

// --- the motion

CommandedMotion CommandedTrajectories::lookUp(const std::vector<int>& joints, const PoseSnapshot& poses,
                                              const VelocitySnapshot& velocities, const ros::Time& now) {
  const Lock lock(mutex_);
  if (now < last_now_) forget();
  last_now_ = now;
  const bool is_known = poses.status.code == QueryStatus::OK && velocities.status.code == QueryStatus::OK;
  if ((waiting_.empty() && driven_.empty()) || !is_known) return {};

  Present present{secondsAt(poses.stamp), secondsAt(now), JointValues(velocities.velocities.size()), velocities};
  for (const int joint : joints)
    present.positions[joint] = positionOf(robot_->robotModel(), poses.poses, velocities, joint);
  for (Driven& driven : driven_) track(driven, present);
  const auto has_begun = [&](const Command& command) { return command.begin <= present.now; };
  for (const Command& command : waiting_)
    if (has_begun(command)) begin(command, present);
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), has_begun), waiting_.end());
  const auto is_over = [&](const Driven& driven) {
    const double end = driven.splines->segments.back().end();
    return present.time - driven.delay >= end || present.time >= end + kLargestDelay;
  };
  driven_.erase(std::remove_if(driven_.begin(), driven_.end(), is_over), driven_.end());
  return motionFrom(present);
}

void CommandedTrajectories::begin(const Command& command, const Present& present) {
  std::optional<Driven> next;
  try {
    if (!command.points.empty())
      next = Driven{std::make_shared<const CommandedSplines>(splinesOf(command, present)), command.joints};
  } catch (const std::invalid_argument& error) {
    ROS_WARN_STREAM_THROTTLE(10.0, command.topic << ": " << error.what() << "; the trajectory before is kept");
    return;
  }
  const auto is_replaced = [&](int joint) { return contains(command.joints, joint); };
  for (Driven& driven : driven_) {
    std::vector<int>& joints = driven.joints;
    joints.erase(std::remove_if(joints.begin(), joints.end(), is_replaced), joints.end());
    if (command.joints.empty() && driven.splines->topic == command.topic) joints.clear();
  }
  driven_.erase(std::remove_if(driven_.begin(), driven_.end(), [](const Driven& d) { return d.joints.empty(); }),
                driven_.end());
  if (!next) return;
  track(*next, present);
  driven_.push_back(std::move(*next));
}

/// They begin with what was commanded until then, if the robot is there, as it may still follow that; else with the way
/// from the present state to that at the begin.
CommandedSplines CommandedTrajectories::splinesOf(const Command& command, const Present& present) const {
  const auto before = std::find_if(driven_.begin(), driven_.end(), [&](const Driven& driven) {
    return driven.stray_joint < 0 && std::all_of(command.joints.begin(), command.joints.end(),
                                                 [&](int joint) { return contains(driven.joints, joint); });
  });
  const scene::RobotModel& robot = robot_->robotModel();
  const bool continues = before != driven_.end();
  const double begin = continues ? command.begin : std::max(command.begin, present.time);
  scene::TrajectoryPoint start = continues ? before->splines->stateAt(begin) : presentState(command, present, begin);
  CommandedSplines splines{command.topic, {}, {}};
  if (continues) {
    const double earliest = begin - kLargestDelay - robot_->config().max_tf_age;
    for (const scene::SplineSegment& segment : before->splines->segments) {
      if (segment.end() < earliest || segment.begin() > begin - kResolutionOfTime) continue;
      const double part = (begin - segment.begin()) / (segment.end() - segment.begin());
      splines.segments.push_back(part < 1.0 ? segment.between(0.0, part) : segment);
    }
  } else if (present.time < begin - kResolutionOfTime) {
    splines.segments.emplace_back(robot, presentState(command, present, present.time), start);
  }
  std::vector<scene::TrajectoryPoint> points;
  for (const scene::TrajectoryPoint& point : command.points) {
    if (command.zero + point.time < begin + kResolutionOfTime) continue;
    points.push_back(point);
    points.back().time += command.zero - begin;
  }
  points = scene::drivenFrom(robot, std::move(start), points);
  for (scene::TrajectoryPoint& point : points) point.time += begin;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) splines.segments.emplace_back(robot, points[i], points[i + 1]);
  findBeyond(command.joints, splines);
  return splines;
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

/// The state at a time if the joints of a command keep their present velocities until then.
scene::TrajectoryPoint CommandedTrajectories::presentState(const Command& command, const Present& present,
                                                           double time) const {
  const auto later = [&](const scene::TrajectoryPoint& point) { return command.zero + point.time > time; };
  const auto first = std::find_if(command.points.begin(), command.points.end(), later);
  const scene::Positions none(present.positions.size(), 0.0);
  scene::TrajectoryPoint state{time, first == command.points.end() ? none : first->positions, none, none};
  for (const int joint : command.joints) {
    if (!present.positions[joint]) continue;
    double position = *present.positions[joint];
    if (!present.velocities.positions[joint])
      position = onTurnNearestTo(state.positions[joint], position, robot_->robotModel().joints[joint]);
    state.velocities[joint] = present.velocities.velocities[joint];
    state.positions[joint] = position + state.velocities[joint] * (time - present.time);
  }
  return state;
}

/// Finds the delay with which the robot follows the splines, and a joint that does not follow them.
void CommandedTrajectories::track(Driven& driven, const Present& present) const {
  const auto price = [&](double delay) {
    const scene::TrajectoryPoint commanded = driven.splines->stateAt(present.time - delay);
    double sum = squared(kPriceOfDelay * delay);
    for (const int joint : driven.joints)
      if (present.positions[joint]) sum += squared(offBy(joint, *present.positions[joint], commanded.positions[joint]));
    return sum;
  };
  double best = 0.0, least = price(best);
  const auto consider = [&](double delay) {
    if (std::abs(delay) > kLargestDelay) return;
    const double own = price(delay);
    if (own < least) std::tie(least, best) = std::tie(own, delay);
  };
  for (int i = 1; i <= 10; ++i)
    for (const double delay : {0.1 * i * kLargestDelay, -0.1 * i * kLargestDelay}) consider(delay);
  for (double step = 0.05 * kLargestDelay; step > 1e-5; step *= 0.5)
    for (const double delay : {best + step, best - step}) consider(delay);

  driven.delay = best;
  driven.stray_joint = -1;
  const scene::TrajectoryPoint commanded = driven.splines->stateAt(present.time - best);
  for (const int joint : driven.joints) {
    if (!present.positions[joint]) continue;
    const double off = std::abs(offBy(joint, *present.positions[joint], commanded.positions[joint]));
    if (off <= allowed(joint) || (driven.stray_joint >= 0 && off <= driven.off)) continue;
    driven.stray_joint = joint;
    driven.off = off;
  }
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
  const scene::Joint& joint = robot_->robotModel().joints[driven.stray_joint];
  std::ostringstream text;
  text << std::setprecision(3) << "joint '" << joint.name << "' is " << driven.off << (turns(joint) ? " rad" : " m")
       << " off the trajectory of " << driven.splines->topic << ": velocities are taken";
  return text.str();
}

CommandedMotion CommandedTrajectories::motionFrom(const Present& present) const {
  CommandedMotion motion;
  for (const Driven& driven : driven_)
    if (driven.stray_joint >= 0) return {{}, {}, {}, textOfStray(driven)};
  for (const std::optional<double>& position : present.positions) motion.positions.push_back(position.value_or(0.0));
  motion.tracking_error.assign(present.positions.size(), 0.0);
  std::ostringstream text;
  text << std::setprecision(3);
  for (const Driven& driven : driven_) {
    FollowedSplines followed{driven.splines, {}, present.time - driven.delay};
    const scene::TrajectoryPoint commanded = driven.splines->stateAt(followed.time);
    for (const int joint : driven.joints) {
      if (!present.positions[joint]) continue;
      followed.joints.push_back(joint);
      const double position = commanded.positions[joint];
      motion.positions[joint] = position + offBy(joint, *present.positions[joint], position);
      motion.tracking_error[joint] = allowed(joint);
    }
    if (followed.joints.empty()) continue;
    text << (motion.followed.empty() ? "along the trajectory of " : " and of ") << driven.splines->topic
         << ", with a delay of " << driven.delay << " s";
    const auto& beyond = driven.splines->beyond;
    const auto next = std::find_if(beyond.begin(), beyond.end(), [&](const CommandedSplines::Excess& excess) {
      return excess.time >= followed.time;
    });
    if (next != beyond.end()) text << ", where in " << next->time - followed.time << " s " << next->text;
    motion.followed.push_back(std::move(followed));
  }
  for (const Command& command : waiting_)
    text << (motion.followed.empty() ? "" : "; ") << "that of " << command.topic << " begins in "
         << command.begin - present.now << " s and is not seen yet";
  motion.text = text.str();
  return motion;
}

}  // namespace proximity_server::node
