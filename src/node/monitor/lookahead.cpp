#include "node/monitor/lookahead.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include "node/robot/conversions.h"
#include "node/services/timed_motion.h"
#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::node {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The joints from a link to the root.
std::vector<int> chainOf(const scene::RobotModel& robot, int link) {
  std::vector<int> joints;
  const auto at = [&](int body) -> const scene::Body& { return robot.bodies[body]; };
  for (int body = robot.links[link].body; at(body).joint >= 0; body = at(body).parent) {
    joints.push_back(at(body).joint);
  }
  std::sort(joints.begin(), joints.end());
  return joints;
}

/// The longest time of a search [s]: a quarter of the period, so that the rest of the cycle is in time. At rate 0 every
/// new set of transforms starts a cycle; few robots publish more than a hundred sets per second.
double budget(const MonitorSettings& settings) { return settings.rate > 0.0 ? 0.25 / settings.rate : 0.0025; }

scene::MotionQuestion questionOf(const MonitorSettings& settings) {
  using Clock = std::chrono::steady_clock;
  scene::MotionQuestion question;
  question.contact_distance = settings.stop_distance;
  question.deadline =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(budget(settings)));
  return question;
}

}  // namespace

std::vector<int> jointsThatMatter(const scene::RobotModel& robot, const std::vector<scene::ShapeRefPair>& pairs) {
  std::vector<int> joints;
  for (const scene::ShapeRefPair& pair : pairs) {
    const std::vector<int> a = chainOf(robot, pair.a.link), b = chainOf(robot, pair.b.link);
    std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(joints));
  }
  for (int& joint : joints) joint = robot.leaderOf(joint).joint;
  std::sort(joints.begin(), joints.end());
  joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
  return joints;
}

std::vector<int> robotsThatMeet(const scene::RobotModel& robots, const std::vector<scene::ShapeRefPair>& pairs) {
  std::set<int> found;
  for (const scene::ShapeRefPair& pair : pairs) {
    const int a = robots.bodies[robots.links[pair.a.link].body].robot;
    const int b = robots.bodies[robots.links[pair.b.link].body].robot;
    if (a != b) found.insert({a, b});
  }
  return {found.begin(), found.end()};
}

Lookahead noLookahead(const MonitorSettings& settings) {
  Lookahead result;
  result.state = settings.lookahead > 0.0 ? Lookahead::UNKNOWN : Lookahead::OFF;
  result.lookahead = settings.lookahead;
  result.contact_distance = settings.stop_distance;
  result.time_free = result.time_to_contact = kNaN;
  result.pair = unknownProximity();
  return result;
}

Lookahead contactAhead(const Robot& robot, scene::MovingScene& scene, const scene::Pairs& pairs,
                       const scene::BodyPoses& poses, const VelocitySnapshot& velocities,
                       const MonitorSettings& settings) {
  Lookahead result = noLookahead(settings);
  result.status = velocities.status;
  if (result.status.code != QueryStatus::OK) return result;

  std::vector<double> travel = velocities.velocities;
  for (double& joint : travel) joint *= settings.lookahead;
  if (!std::all_of(travel.begin(), travel.end(), [](double joint) { return std::isfinite(joint); })) {
    result.status.code = QueryStatus::NO_VELOCITY;
    result.status.message = "a velocity times the lookahead is not finite";
    return result;
  }
  const TimedMotion motion = motionWithinLimits(robot, poses, travel, velocities.positions, settings.lookahead);
  const scene::MotionQuestion question = questionOf(settings);
  const scene::RobotContact found = scene.timeOfContact(pairs, motion.motion, question);
  result.status = completeness(found.counts);
  if (result.status.code != QueryStatus::OK) return result;
  assignStops(result, robot, motion);
  result.status = statusOf(found.status, question);
  result.time_free = motion.onClock(found.t_free);
  if (found.contact) {
    result.state = Lookahead::CONTACT;
    result.time_to_contact = motion.onClock(found.t_contact);
    result.pair = toMessage(robot, motion, found.t_contact, found.pair);
  } else if (result.status.code == QueryStatus::OK) {
    result.state = Lookahead::FREE;
  }
  return result;
}

}  // namespace proximity_server::node
