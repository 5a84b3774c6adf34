#include "node/monitor/lookahead.h"

#include "node/answers/conversions.h"
#include "node/answers/motions.h"
#include "node/answers/statuses.h"
#include "node/robot/query_status.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/durations.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

/// So many ways in which joints may follow commands are searched within the time of one: those of five controllers that
/// may follow their trajectories or not.
constexpr std::size_t kMostChoices = 32;

/// Tells that moving objects are assumed to rest, unless it is known that they do; "" for none.
std::string restingText(const LookaheadStart& start) {
  if (start.may_move.empty()) return {};
  return "objects in frame '" + start.frames.names[start.may_move.front()] + "' are taken to rest where they are";
}

scene::MotionQuestion questionOf(const scene::PairDistances& stop, std::chrono::steady_clock::time_point deadline) {
  scene::MotionQuestion question;
  question.thresholds = &stop;
  question.deadline = deadline;
  return question;
}

/// The frames of objects, for a motion from inRoot().
scene::RobotMotion::ObjectFrames objectFrames(const Robot& robot, const LookaheadStart& start) {
  return objectFramesInRoot(robot, start.state.poses(), start.frames, start.state.frames());
}

/// The motion of the joints during the lookahead. Returns nullopt, with the reason in `status`, if a velocity is too
/// large or a position is too far beyond the limits of its joint.
std::optional<scene::LimitedMotion> motionAhead(const Robot& robot, const LookaheadStart& start,
                                                const std::vector<double>& velocities, const MonitorSettings& settings,
                                                QueryStatus& status) {
  std::vector<double> travel = velocities;
  for (double& joint : travel) joint *= settings.lookahead;
  try {
    if (!std::all_of(travel.begin(), travel.end(), [](double joint) { return std::isfinite(joint); }))
      throw std::invalid_argument("a velocity times the lookahead is not finite");
    scene::LimitedMotion limited =
        motionWithinLimits(robot, start.state.poses(), travel, start.stated, settings.lookahead);
    limited.motion.carryObjects(objectFrames(robot, start));
    return limited;
  } catch (const std::invalid_argument& error) {
    status = statusOf(QueryStatus::NO_VELOCITY, error.what());
    return std::nullopt;
  }
}

/// The time of a search along splines: it is exact for those whose delay is known worst. Times [s] count from the stamp
/// of the poses, with the delay that fits these splines best.
struct SearchTime {
  double begin = 0.0, end;           ///< [s]
  double behind = 0.0, ahead = 0.0;  ///< [s] true times differ from that of the search by at most so much
  const FollowedSplines* exact = nullptr;
};
SearchTime searchTimeOf(const CommandedMotion& commanded, double lookahead) {
  SearchTime time{0.0, lookahead};
  for (const FollowedSplines& followed : commanded.followed)
    if (!time.exact || followed.behind + followed.ahead > time.behind + time.ahead)
      time = {-followed.behind, lookahead + followed.ahead, followed.behind, followed.ahead, &followed};
  return time;
}

/// The parameters of the search between which each joint is on one segment: its ends, those of the splines, and the
/// stops at limits.
std::vector<double> knotsOf(const CommandedMotion& commanded, const scene::LimitedMotion& others,
                            const SearchTime& search) {
  std::vector<double> knots{0.0, 1.0};
  const auto add = [&](double time) {
    const double knot = (time - search.begin) / (search.end - search.begin);
    if (knot > 0.0 && knot < 1.0) knots.push_back(knot);
  };
  add(0.0);
  add(others.motion.timeAt(1.0));
  for (const scene::JointStop& stop : others.stops) add(others.motion.timeAt(stop.time));
  for (const FollowedSplines& followed : commanded.followed) {
    for (const scene::SplineSegment& segment : followed.splines->segments) {
      add(segment.begin() - followed.time);
      add(segment.end() - followed.time);
    }
  }
  std::sort(knots.begin(), knots.end());
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
  return knots;
}

/// [rad] or [m] How far each joint may be off a segment of the search: by its tracking error, by what its splines are
/// off, and by its way in the time by which they may be earlier or later than the search.
std::vector<double> errorsOn(const scene::SplineSegment& segment, const CommandedMotion& commanded,
                             const std::vector<double>& velocities, const SearchTime& search) {
  std::vector<double> errors = commanded.tracking_error;
  for (std::size_t i = 0; i < errors.size(); ++i)
    errors[i] += std::abs(velocities[i]) * std::max(search.behind, search.ahead);
  for (const FollowedSplines& followed : commanded.followed) {
    const double shift =
        &followed == search.exact ? 0.0 : std::max(search.behind + followed.ahead, search.ahead + followed.behind);
    const double from = followed.time + segment.begin() - shift, to = followed.time + segment.end() + shift;
    for (const int joint : followed.joints)
      errors[joint] +=
          followed.splines->inexactAt(joint, from) + shift * followed.splines->largestSpeed(joint, from, to);
  }
  return errors;
}

/// The velocities of the joints that follow no commands, and 0 for all others.
std::vector<double> withoutFollowers(std::vector<double> velocities, const CommandedMotion& commanded) {
  for (const FollowedSplines& followed : commanded.followed)
    for (const int joint : followed.joints) velocities[joint] = 0.0;
  return velocities;
}

/// The motion of all joints. `others` and `velocities` are of those that follow no commands.
scene::Motion motionAlong(const CommandedMotion& commanded, const Robot& robot, const LookaheadStart& start,
                          const scene::LimitedMotion& others, const std::vector<double>& velocities,
                          const SearchTime& search) {
  const double duration = others.motion.timeAt(1.0);
  std::vector<double> stops(velocities.size(), duration);
  for (const scene::JointStop& stop : others.stops) stops[stop.joint] = others.motion.timeAt(stop.time);
  const auto pointAt = [&](double time) {
    scene::TrajectoryPoint point{time, commanded.positions};
    for (std::size_t i = 0; i < stops.size(); ++i)
      point.positions[i] += velocities[i] * std::clamp(time, 0.0, stops[i]);
    return point;
  };
  auto rest = scene::RobotMotion::ofTravel(robot.robotModel(), inRoot(robot, start.state.poses()),
                                           std::vector<double>(velocities.size()));
  rest.carryObjects(objectFrames(robot, start));
  const std::vector<double> knots = knotsOf(commanded, others, search);
  const auto timeAt = [&](double knot) { return search.begin + knot * (search.end - search.begin); };
  std::vector<scene::Motion::Piece> pieces;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double from = timeAt(knots[i]), to = timeAt(knots[i + 1]);
    scene::SplineSegment segment(robot.robotModel(), pointAt(from), pointAt(to));
    for (const FollowedSplines& followed : commanded.followed)
      segment.follow(followed.splines->between(followed.time + from, followed.time + to), followed.joints);
    std::vector<double> errors = errorsOn(segment, commanded, velocities, search);
    pieces.push_back({knots[i], knots[i + 1], rest, commanded.positions, {}, std::move(segment), std::move(errors)});
  }
  scene::Motion motion(std::move(pieces));
  motion.setTime(search.begin, search.end);
  return motion;
}

/// Tells which inequality is broken first along the splines until a parameter, and when; "" for none.
std::string brokenAlong(const scene::Motion& motion, double until, const scene::RobotModel& robot) {
  for (const scene::Motion::Piece& piece : motion.pieces()) {
    if (piece.begin > 0.0 && !(piece.begin < until)) break;
    const auto broken = piece.spline->brokenInequalities(robot);
    if (broken.empty()) continue;
    return "after " + system::secondsText(std::max(0.0, piece.spline->timeAt(broken.front().time))) + " " +
           broken.front().inequality->brokenText(broken.front().excess);
  }
  return {};
}

/// The answer if all joints of `commanded` follow their splines, and all others keep their velocities.
Lookahead contactAlong(const CommandedMotion& commanded, const Robot& robot, scene::MotionSearch& scene,
                       const LookaheadStart& start, const VelocitySnapshot& velocities,
                       const scene::MotionQuestion& question, const MonitorSettings& settings) {
  Lookahead result = noLookahead(settings);
  const std::vector<double> of_others = withoutFollowers(velocities.velocities, commanded);
  const std::optional<scene::LimitedMotion> others = motionAhead(robot, start, of_others, settings, result.status);
  if (!others) return result;
  const SearchTime time = searchTimeOf(commanded, settings.lookahead);
  std::optional<scene::Motion> spline;
  if (!commanded.followed.empty()) spline = motionAlong(commanded, robot, start, *others, of_others, time);
  const scene::Motion& motion = spline ? *spline : others->motion;
  const scene::RobotTimeOfContact found = scene.timeOfContact(robot.candidates(), motion, question);
  result.status = completeness(found.counts);
  if (result.status.code != QueryStatus::OK) return result;
  assignStops(result, robot, *others);
  const auto within = [&](double seconds) { return std::clamp(seconds, 0.0, settings.lookahead); };
  result.time_free = within(motion.timeAt(found.t_free) - time.ahead);
  result.status = statusOfContact(found, result.time_free, question);
  if (found.contact) {
    result.state = Lookahead::CONTACT;
    result.time_to_contact = within(motion.timeAt(found.t_contact));
    result.pair_contact_distance = question.thresholds->of(found.pair.asked);
    result.pair = toMessage({robot.robotModel(), scene.objects()}, motion, found.t_contact, found.state, found.pair);
  } else if (result.status.code == QueryStatus::OK) {
    result.state = Lookahead::FREE;
    result.time_free = settings.lookahead;
  }
  if (result.status.code != QueryStatus::OK) return result;
  const double until = found.contact ? found.t_contact : 1.0;
  const std::string limits =
      spline ? joined(brokenAlong(motion, until, robot.robotModel()), assumedText(robot.robotModel(), *others))
             : limitsText(robot.robotModel(), start.state.poses(), start.stated, *others);
  result.status.message = joined(restingText(start), limits);
  return result;
}

/// Joins two answers of which either may be true: the earlier contact counts, and FREE only if both are FREE.
Lookahead eitherOf(Lookahead a, Lookahead b) {
  if (std::isnan(b.time_free) || (b.state == Lookahead::CONTACT && !(a.time_to_contact <= b.time_to_contact)) ||
      (b.state == Lookahead::UNKNOWN && a.state == Lookahead::FREE))
    std::swap(a, b);
  if (b.time_free < a.time_free) {
    a.time_free = b.time_free;
    if (b.state == Lookahead::UNKNOWN && a.state == Lookahead::CONTACT) a.status = b.status;
  }
  return a;
}

/// The splines that joints may follow together, of those from `next` on and with `chosen`: of those that are only
/// perhaps followed each may be left out. Their joints keep their velocities then, or follow what comes later.
void addChoices(const std::vector<FollowedSplines>& all, std::size_t next, const std::vector<FollowedSplines>& chosen,
                std::vector<std::vector<FollowedSplines>>& choices) {
  if (choices.size() > kMostChoices) return;
  if (next == all.size()) return choices.push_back(chosen);
  FollowedSplines followed = all[next];
  const auto is_taken = [&](int joint) {
    return std::any_of(chosen.begin(), chosen.end(), [&](const FollowedSplines& other) {
      return std::find(other.joints.begin(), other.joints.end(), joint) != other.joints.end();
    });
  };
  std::vector<int>& joints = followed.joints;
  joints.erase(std::remove_if(joints.begin(), joints.end(), is_taken), joints.end());
  if (!joints.empty()) {
    std::vector<FollowedSplines> with = chosen;
    with.push_back(followed);
    addChoices(all, next + 1, with, choices);
  }
  if (joints.empty() || followed.certainty == FollowedSplines::Certainty::PerhapsFollowed)
    addChoices(all, next + 1, chosen, choices);
}

/// The motion in which joints follow these splines only, and all others keep their velocities.
CommandedMotion withOnly(std::vector<FollowedSplines> followed, CommandedMotion commanded) {
  std::vector<double> errors(commanded.tracking_error.size(), 0.0);
  for (const FollowedSplines& splines : followed)
    for (const int joint : splines.joints) errors[joint] = commanded.tracking_error[joint];
  commanded.followed = std::move(followed);
  commanded.tracking_error = std::move(errors);
  return commanded;
}

}  // namespace

Lookahead noLookahead(const MonitorSettings& settings) {
  Lookahead result;
  result.state = settings.lookahead > 0.0 ? Lookahead::UNKNOWN : Lookahead::OFF;
  result.lookahead = settings.lookahead;
  result.contact_distance = settings.stop_distance;
  result.object_contact_distance = settings.object_stop_distance;
  result.time_free = result.time_to_contact = result.pair_contact_distance = kNaN;
  result.pair = unknownProximity();
  return result;
}

double searchTime(const MonitorSettings& settings) { return settings.rate > 0.0 ? 0.25 / settings.rate : 0.0025; }

std::chrono::steady_clock::time_point searchDeadline(const MonitorSettings& settings) {
  return system::deadlineIn(searchTime(settings));
}

Lookahead contactAhead(const CommandedMotion& commanded, const Robot& robot, scene::MotionSearch& scene,
                       const LookaheadStart& start, const VelocitySnapshot& velocities,
                       const scene::PairDistances& stop, const MonitorSettings& settings) {
  Lookahead result = noLookahead(settings);
  result.status = velocities.status;
  if (result.status.code != QueryStatus::OK) return result;
  const scene::MotionQuestion question = questionOf(stop, searchDeadline(settings));
  std::vector<std::vector<FollowedSplines>> choices;
  addChoices(commanded.followed, 0, {}, choices);
  if (choices.size() > kMostChoices) {
    result.status = statusOf(QueryStatus::OVER_BUDGET, "joints may follow their trajectories in more than " +
                                                           std::to_string(kMostChoices) + " ways: " + commanded.text);
    return result;
  }
  for (std::vector<FollowedSplines>& choice : choices) {
    const bool is_first = &choice == &choices.front();
    Lookahead found =
        contactAlong(withOnly(std::move(choice), commanded), robot, scene, start, velocities, question, settings);
    result = is_first ? std::move(found) : eitherOf(std::move(result), std::move(found));
    if (result.status.code != QueryStatus::OK) break;
  }
  return result;
}

}  // namespace proximity_server::node
