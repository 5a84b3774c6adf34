#include "node/answers/conversions.h"
#include "node/answers/statuses.h"
#include "node/answers/timed_motion.h"
#include "node/services/answered.h"
#include "node/services/motion_requests.h"
#include "node/services/queries.h"
#include "node/services/trajectory_requests.h"
#include "system/durations.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::node {
namespace {

using narrowphase::Status;

QueryTrajectoryResponse emptyQueryTrajectory() {
  QueryTrajectoryResponse response;
  response.t_free = response.t_contact = kNaN;
  response.segment = -1;
  response.pair = unknownProximity();
  return response;
}

/// The trajectory of a request, with the poses that tf adds to its points, and the frames of objects.
struct Trajectory {
  const Robot& robot;
  const RobotAndObjects model;
  const WayPoints& way;
  const JointSnapshot& from_tf;
  const CarrierFrames& frames;
  const scene::FramePoses& poses_of_frames;

  scene::BodyPoses posesAt(const scene::Positions& positions) const {
    return inReference(robot, posesInRoot(robot, way.valuesAt(positions), from_tf), from_tf.roots);
  }
  sensor_msgs::JointState stateAt(const scene::Positions& positions) const {
    sensor_msgs::JointState state;
    for (const int joint : way.joints) {
      state.name.push_back(robot.robotModel().joints[joint].name);
      state.position.push_back(positions[joint]);
    }
    return state;
  }
};

/// The first contact in a segment; times are those of the trajectory.
struct ContactInSegment {
  scene::RobotTimeOfContact found;
  double t_free, t_contact;
  scene::Positions state;  ///< in contact; empty: none is known
  Proximity pair;
};

struct MinimumInSegment {
  Status status;
  MotionMinimum message;
};

/// The segments in which every joint moves at constant velocity.
class LinearSegments {
 public:
  LinearSegments(const Trajectory& trajectory, const RequestedPairs& pairs, const scene::MotionQuestion& question)
      : trajectory_(trajectory), pairs_(pairs.asked()), question_(question), scenes_(pairs.borrowScenes()) {
    const std::vector<scene::TrajectoryPoint>& points = trajectory.way.points;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const scene::TrajectoryPoint &from = points[i], &to = points[i + 1];
      motions_.push_back(motionOfJoints(trajectory.robot, trajectory.posesAt(from.positions),
                                        travelBetween(from.positions, to.positions), from.time, to.time - from.time));
      carryObjects(trajectory.robot, trajectory.frames, trajectory.poses_of_frames, motions_.back());
    }
  }

  std::size_t size() const { return motions_.size(); }

  ContactInSegment contactIn(std::size_t segment) {
    const TimedMotion& motion = motions_[segment];
    const scene::RobotTimeOfContact found = scenes_->moving().timeOfContact(pairs_, motion.motion, question_);
    ContactInSegment contact{found, motion.timeAt(found.t_free), kNaN, {}, unknownProximity()};
    if (!found.contact) return contact;
    contact.t_contact = motion.timeAt(found.t_contact);
    contact.state = positionsAt(segment, found.t_contact);
    contact.pair = toMessage(trajectory_.model, motion, found.t_contact, found.pair);
    return contact;
  }

  MinimumInSegment minimumIn(std::size_t segment) {
    const scene::RobotMinimum found = scenes_->moving().minimum(pairs_, motions_[segment].motion, question_);
    return {found.status, toMessage(trajectory_.model, motions_[segment], found)};
  }

  /// A warning about the first point of the trajectory at which a joint is beyond its limit, or which breaks an
  /// inequality; "" if there is none. Between two points that break no inequality, none is broken.
  std::string beyondLimits() const {
    const std::vector<scene::TrajectoryPoint>& points = trajectory_.way.points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::string broken =
          brokenText(trajectory_.robot, trajectory_.way.valuesAt(points[i].positions), trajectory_.from_tf);
      if (!broken.empty()) return "point " + std::to_string(i) + " is the first beyond a limit: " + broken;
      for (const int index : trajectory_.way.joints) {
        const scene::Joint& joint = trajectory_.robot.robotModel().joints[index];
        const double position = points[i].positions[index];
        const bool is_below = position < joint.lower - kWritingError;
        if (joint.mimic || (!is_below && !(position > joint.upper + kWritingError))) continue;
        std::ostringstream text;
        text << "point " << i << " is the first beyond a limit: joint '" << joint.name << "' is at " << position
             << ", its " << (is_below ? "lower" : "upper") << " limit is " << (is_below ? joint.lower : joint.upper);
        return text.str();
      }
    }
    return {};
  }

 private:
  scene::Positions positionsAt(std::size_t segment, double parameter) const {
    scene::Positions positions = trajectory_.way.points[segment].positions;
    const scene::Positions& to = trajectory_.way.points[segment + 1].positions;
    for (std::size_t i = 0; i < to.size(); ++i) positions[i] += parameter * (to[i] - positions[i]);
    return positions;
  }

  const Trajectory& trajectory_;
  const scene::Pairs pairs_;
  const scene::MotionQuestion& question_;
  const ScenePool::Lease scenes_;
  std::vector<TimedMotion> motions_;
};

/// The segments along splines, and what lies within the tracking error of them.
class SplineSegments {
 public:
  SplineSegments(const Trajectory& trajectory, const RequestedPairs& pairs, const scene::MotionQuestion& question,
                 std::vector<double> tracking_error)
      : trajectory_(trajectory),
        pairs_(pairs.asked()),
        scenes_(pairs.borrowScenes()),
        splines_(splinesOf(trajectory.robot, trajectory.way)),
        motion_(splineMotion(
            trajectory.robot,
            [&trajectory](const scene::Positions& positions) { return trajectory.posesAt(positions); },
            trajectory.way.points.front().positions, trajectory.frames, trajectory.poses_of_frames)),
        question_{question, std::move(tracking_error), motion_.frames, motion_.poses} {}

  std::size_t size() const { return splines_.size(); }

  ContactInSegment contactIn(std::size_t segment) {
    const scene::SplineContact found = scenes_->splines().timeOfContact(pairs_, splines_[segment], question_);
    ContactInSegment contact{found, timeAt(segment, found.t_free), kNaN, found.state, unknownProximity()};
    if (found.contact) contact.t_contact = timeAt(segment, found.t_contact);
    if (found.pair.result.status != Status::Unknown)
      contact.pair = toMessage(trajectory_.model, motion_,
                               found.contact ? found.state : splines_[segment].at(found.t_free), found.pair);
    return contact;
  }

  MinimumInSegment minimumIn(std::size_t segment) {
    const scene::SplineMinimum found = scenes_->splines().minimum(pairs_, splines_[segment], question_);
    MotionMinimum message = unknownMinimum();
    message.lower_bound = found.lower_bound;
    message.upper_bound = found.upper_bound;
    if (found.state.empty()) return {found.status, message};
    message.time = timeAt(segment, found.time);
    message.pair = toMessage(trajectory_.model, motion_, found.state, found.pair);
    return {found.status, message};
  }

  /// A warning about the first segment in which a joint of the trajectory is beyond its limit, or which breaks an
  /// inequality; "" if there is none.
  std::string beyondLimits() const {
    const JointValues resting = restingPositions();
    for (std::size_t i = 0; i < splines_.size(); ++i) {
      const auto broken = splines_[i].brokenInequalities(trajectory_.robot.robotModel(), resting);
      if (!broken.empty())
        return "segment " + std::to_string(i) + " is the first beyond a limit: at " +
               system::secondsText(timeAt(i, broken.front().time)) + " " +
               broken.front().inequality->brokenText(broken.front().excess);
      for (const scene::SplineSegment::Excess& excess : splines_[i].beyondLimits(trajectory_.robot.robotModel())) {
        const std::vector<int>& named = trajectory_.way.joints;
        const bool is_named = std::find(named.begin(), named.end(), excess.joint) != named.end();
        if (!is_named || !(std::abs(excess.position - excess.limit) > kWritingError)) continue;
        std::ostringstream text;
        text << "segment " << i << " is the first beyond a limit: at " << timeAt(i, excess.time) << " s joint '"
             << trajectory_.robot.robotModel().joints[excess.joint].name << "' is at " << excess.position << ", its "
             << (excess.position < excess.limit ? "lower" : "upper") << " limit is " << excess.limit;
        return text.str();
      }
    }
    return {};
  }

 private:
  /// Those of the joints that the trajectory does not name; empty if no inequality needs them.
  JointValues restingPositions() const {
    if (trajectory_.robot.robotModel().inequalities.empty()) return {};
    const JointValues unnamed(trajectory_.robot.robotModel().joints.size());
    const scene::Positions positions =
        positionsOf(trajectory_.robot, completed(unnamed, trajectory_.way.missing), trajectory_.from_tf);
    JointValues resting(positions.begin(), positions.end());
    for (const int joint : trajectory_.way.joints) resting[joint].reset();
    return resting;
  }

  double timeAt(std::size_t segment, double parameter) const { return splines_[segment].timeAt(parameter); }

  const Trajectory& trajectory_;
  const scene::Pairs pairs_;
  const ScenePool::Lease scenes_;
  const std::vector<scene::SplineSegment> splines_;
  const SplineMotion motion_;
  const scene::SplineQuestion question_;
};

/// Searches segment by segment until a contact is found, or until the search of a segment is not complete.
template <class Segments>
void findContact(Segments& segments, const Trajectory& trajectory, const scene::MotionQuestion& question,
                 QueryTrajectoryResponse& response) {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const ContactInSegment contact = segments.contactIn(i);
    require(completeness(contact.found.counts));
    response.status = statusOfContact(contact.found, contact.t_free, question);
    response.contact = contact.found.contact;
    response.t_free = contact.t_free;
    response.t_contact = contact.t_contact;
    response.pair = contact.pair;
    response.may_touch = !contact.found.contact && response.status.code != QueryStatus::OK;
    if (contact.found.contact) {
      response.segment = static_cast<std::int32_t>(i);
      response.state = trajectory.stateAt(contact.state);
    }
    if (contact.found.contact || response.status.code != QueryStatus::OK) return;
  }
}

template <class Segments>
void findMinima(Segments& segments, const scene::MotionQuestion& question, QueryTrajectoryResponse& response) {
  response.segments.assign(segments.size(), unknownMinimum());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const MinimumInSegment found = segments.minimumIn(i);
    response.segments[i] = found.message;
    const QueryStatus status = statusOf(found.status, question);
    if (status.code != QueryStatus::OK) {
      response.status = status;
      return;
    }
    response.segments_finished = static_cast<std::uint32_t>(i + 1);
  }
}

template <class Segments>
void answerAlong(Segments segments, const Trajectory& trajectory, const scene::MotionQuestion& question,
                 const QueryTrajectoryRequest& request, QueryTrajectoryResponse& response) {
  findContact(segments, trajectory, question, response);
  if (!request.skip_minimum) findMinima(segments, question, response);
  if (response.status.code == QueryStatus::OK) response.status.message = segments.beyondLimits();
}

/// The transforms that the points leave to tf. Those of the joints of the points are looked up for the present state.
JointSnapshot awaitTf(const Robot& robot, TfPoses& tf, const RequestedPairs& pairs, const WayPoints& way,
                      const QueryTrajectoryRequest& request) {
  const std::vector<JointValues> given{way.valuesAt(way.points.front().positions)};  // the same joints in all points
  std::vector<int> joints = coupledJoints(robot.robotModel(), given);
  if (request.from_present_state) joints.insert(joints.end(), way.joints.begin(), way.joints.end());
  return missingFromTf(robot, tf, pairs.bodies(), given, request.stamp, joints);
}

}  // namespace

QueryTrajectoryResponse answer(const Robot& robot, TfPoses& tf, const QueryTrajectoryRequest& request) {
  return answered(emptyQueryTrajectory(), [&](QueryTrajectoryResponse& response) {
    const auto thresholds = robot.thresholds();
    scene::MotionQuestion question = motionQuestion(request.contact_distance, request.tolerance, thresholds->stop);
    const double budget = timeBudget(robot, request.time_budget);
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    WayPoints way = wayPointsOf(robot, request);
    const std::vector<double> tracking_error = trackingErrorOf(robot, way, request);
    const JointSnapshot from_tf = awaitTf(robot, tf, pairs, way, request);
    response.header.stamp = from_tf.stamp;
    response.header.frame_id = robot.referenceFrame();
    require(from_tf.status);
    if (request.from_present_state) way = drivenFromPresent(robot, way, from_tf, request);
    const CarrierFrames frames = pairs.frames();
    const FrameSnapshot objects = framesFromTf(robot, tf, frames, from_tf, request.stamp);
    require(objects.status);
    const Trajectory trajectory{robot, {robot.robotModel(), &pairs.objects()}, way, from_tf, frames, objects.poses};
    question.deadline = system::deadlineIn(budget);
    if (request.interpolation == QueryTrajectoryRequest::LINEAR && tracking_error.empty())
      answerAlong(LinearSegments(trajectory, pairs, question), trajectory, question, request, response);
    else
      answerAlong(SplineSegments(trajectory, pairs, question, tracking_error), trajectory, question, request, response);
    response.certified = motionText(robot, way, tracking_error, request);
  });
}

}  // namespace proximity_server::node
