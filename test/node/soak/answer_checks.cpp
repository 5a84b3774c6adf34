#include "node/soak/answer_checks.h"

#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

namespace proximity_server::node {

using namespace narrowphase;
using namespace scene;

/// An answer about the first contact, on the clock of a motion.
struct SaidContact {
  double begin;  ///< [s] of the motion
  bool contact;
  double t_free, t_contact;
};

/// An answer about the smallest distance of a motion from `begin` to `end` [s].
struct SaidMinimum {
  double begin, end;
  const MotionMinimum& minimum;
};

namespace {

/// [m] Poses that went through a quaternion, and forward kinematics, each round by a few ulp at every joint of the
/// demo's chains, which reach about 1 m.
constexpr double kRounding = 1e-12;
constexpr double kTolerance = 1e-9;        // [m] of the node, the default
constexpr double kMotionTolerance = 1e-6;  // [m] of motions, the default
constexpr int kSamples = 5;                // of a motion

template <class... Parts>
Verdict because(const Parts&... parts) {
  std::ostringstream text;
  text.precision(12);
  (text << ... << parts);
  return text.str();
}

bool isUnit(const geometry_msgs::Vector3& v) { return std::abs(v.x * v.x + v.y * v.y + v.z * v.z - 1.0) <= 1e-9; }

/// Checks what holds for any poses.
Verdict soundness(const Proximity& said) {
  if (said.state == Proximity::UNKNOWN) return because(said.a.link, " and ", said.b.link, " are unknown");
  if (!(said.lower_bound <= said.upper_bound))
    return because("bounds cross: ", said.lower_bound, ", ", said.upper_bound);
  if (!(said.distance >= said.lower_bound - kRounding && said.distance <= said.upper_bound + kRounding)) {
    return because("distance ", said.distance, " outside of ", said.lower_bound, ", ", said.upper_bound);
  }
  if (said.guaranteed > said.lower_bound)
    return because("guaranteed are ", said.guaranteed, ", above the lower bound ", said.lower_bound);
  if (!said.points_valid) return {};
  const double gap = std::hypot(said.point_b.x - said.point_a.x - said.distance * said.normal.x,
                                said.point_b.y - said.point_a.y - said.distance * said.normal.y,
                                said.point_b.z - said.point_a.z - said.distance * said.normal.z);
  if (!(gap <= 1e-9) || !isUnit(said.normal)) return because("the points are not the distance apart, by ", gap);
  return {};
}

/// Two enclosures of one distance.
Verdict agreement(const Proximity& said, const PairProximity& truth) {
  const Verdict verdict = soundness(said);
  if (!verdict.empty()) return verdict;
  const bool meet = said.lower_bound <= truth.result.upper_bound + kRounding &&
                    truth.result.lower_bound <= said.upper_bound + kRounding;
  if (meet) return {};
  return because(said.a.link, " and ", said.b.link, ": said ", said.lower_bound, " to ", said.upper_bound, ", true ",
                 truth.result.lower_bound, " to ", truth.result.upper_bound);
}

bool isEmpty(const proximity_server::ShapeRef& ref) { return ref.link.empty(); }

}  // namespace

AnswerChecks::AnswerChecks(const std::shared_ptr<const SceneModel>& model) : robot_(model->robot), scene_(model) {}

void AnswerChecks::place(const ros::Time& stamp) { placeIn(robot_.positionsAt(stamp)); }

void AnswerChecks::placeIn(const std::vector<double>& positions) {
  const RobotModel& robot = robot_.robot();
  const BodyPoses poses = forwardKinematics(robot, positions);
  if (!scene_.objects()) return scene_.update(poses);
  FramePoses frames;
  for (const std::string& name : scene_.objects()->frames()) {
    const Link& link = robot.links[robot.findLink(name)];
    frames.emplace_back(*poses[link.body] * link.body_T_link);
  }
  scene_.update(poses, frames);
}

std::vector<double> AnswerChecks::positionsOf(const sensor_msgs::JointState& state) const {
  std::map<std::string, double> named;
  for (std::size_t i = 0; i < state.name.size(); ++i) named[state.name[i]] = state.position[i];
  std::vector<double> positions;
  for (const Joint& joint : robot_.robot().joints)
    positions.push_back(named.count(joint.name) ? named[joint.name] : 0.0);
  return positions;
}

scene::ShapeRef AnswerChecks::refOf(const proximity_server::ShapeRef& ref) const {
  if (ref.kind == proximity_server::ShapeRef::LINK) return {robot_.robot().findLink(ref.link)};
  return scene::ShapeRef::ofObject(scene_.objects() ? scene_.objects()->find(ref.link) : -1);
}

/// Throws std::invalid_argument where the scene has not such an object.
ShapeRefPair AnswerChecks::pairOf(const proximity_server::ShapeRef& a, const proximity_server::ShapeRef& b) const {
  return {refOf(a), refOf(b)};
}

PairProximity AnswerChecks::closest(const proximity_server::ShapeRef& a, const proximity_server::ShapeRef& b) {
  return isEmpty(a) ? *scene_.minimum(scene_.candidates()) : scene_.proximity(pairOf(a, b));
}

PairProximity AnswerChecks::closestIn(const std::vector<double>& positions, const Asked& asked) {
  placeIn(positions);
  return closest(asked.a, asked.b);
}

Verdict AnswerChecks::check(const MinimumDistanceRequest& request, const MinimumDistanceResponse& response) {
  place(response.header.stamp);
  return agreement(response.pair, closest(request.a, request.b));
}

Verdict AnswerChecks::check(const SeparationAxisRequest& request, const SeparationAxisResponse& response) {
  place(response.header.stamp);
  const PairProximity truth = closest(request.a, request.b);
  const double distance = truth.result.distance;
  if (response.separated && !(truth.result.upper_bound > request.margin - kRounding)) {
    return because("separated by more than ", request.margin, ", but the distance is ", distance);
  }
  if (!response.separated && truth.result.lower_bound > request.margin + kTolerance + kRounding) {
    return because("not separated by ", request.margin, ", but the distance is ", distance);
  }
  if (!response.separated) return {};
  if (!(response.gap <= truth.result.upper_bound + kRounding)) return because("gap ", response.gap, " of ", distance);
  return isUnit(response.axis) ? Verdict() : because("the axis is no direction");
}

Verdict AnswerChecks::check(const PenetrationDepthRequest& request, const PenetrationDepthResponse& response) {
  place(response.header.stamp);
  const PairProximity truth = closest(request.a, request.b);
  const double depth = std::max(0.0, -truth.result.distance);
  if (response.penetrating != (depth > 0.0) && std::abs(truth.result.distance) > kTolerance + kRounding) {
    return because("penetrating: ", int{response.penetrating}, ", but the distance is ", truth.result.distance);
  }
  const double slack = truth.result.upper_bound - truth.result.lower_bound + kTolerance + kRounding;
  if (!(std::abs(response.depth - depth) <= slack)) return because("depth ", response.depth, ", true ", depth);
  return {};
}

Verdict AnswerChecks::check(const QueryPairsRequest& request, const QueryPairsResponse& response) {
  place(response.header.stamp);
  return checkPosed(request, response.pairs);
}

/// In the poses in which the scene is.
Verdict AnswerChecks::checkPosed(const QueryPairsRequest& request, const std::vector<Proximity>& said) {
  for (const Proximity& pair : said) {
    const Verdict verdict = agreement(pair, scene_.proximity(pairOf(pair.a, pair.b)));
    if (!verdict.empty()) return verdict;
  }
  const Candidates& pairs = scene_.candidates();
  if (request.mode == QueryPairsRequest::MINIMUM || request.mode == QueryPairsRequest::K_CLOSEST) {
    const std::size_t asked = std::max<std::size_t>(1, request.k);
    const std::vector<PairProximity> truth = scene_.closest(pairs, static_cast<int>(asked));
    if (said.size() != truth.size()) return because(said.size(), " closest pairs, not ", truth.size());
    for (std::size_t i = 0; i < said.size(); ++i) {
      // Either of two pairs that are equally far may come first.
      if (std::abs(said[i].distance - truth[i].result.distance) > 2.0 * kTolerance) {
        return because("number ", i, " of the closest is ", said[i].distance, " away, not ", truth[i].result.distance);
      }
    }
  }
  const std::size_t checked =
      pairs.size() + (scene_.objects() ? static_cast<std::size_t>(scene_.objects()->pairCount()) : 0);
  if (request.mode == QueryPairsRequest::PER_PAIR && said.size() != checked) {
    return because(said.size(), " pairs of ", checked);
  }
  if (request.mode == QueryPairsRequest::BELOW_THRESHOLD) return checkNumberBelow(request.threshold, said.size());
  return {};
}

/// In the poses in which the scene is.
Verdict AnswerChecks::checkNumberBelow(double threshold, std::size_t said) {
  Question question;
  question.threshold = threshold - 2.0 * kTolerance;
  const std::size_t least = scene_.below(scene_.candidates(), question).size();
  question.threshold = threshold + 2.0 * kTolerance;
  const std::size_t most = scene_.below(scene_.candidates(), question).size();
  if (said < least || said > most) return because(said, " pairs below ", threshold, ", true ", least);
  return {};
}

Verdict AnswerChecks::check(const QueryConfigurationRequest& request, const QueryConfigurationResponse& response) {
  if (response.states.size() != request.states.size()) return because(response.states.size(), " states");
  QueryPairsRequest each;
  each.mode = request.mode;
  each.k = request.k;
  each.threshold = request.threshold;
  for (std::size_t i = 0; i < request.states.size(); ++i) {
    placeIn(positionsOf(request.states[i]));
    const Verdict verdict = checkPosed(each, response.states[i].pairs);
    if (!verdict.empty()) return because("state ", i, ": ", verdict);
  }
  return {};
}

/// No sample before t_free is in contact, and the one at t_contact is.
Verdict AnswerChecks::checkContact(const StateAt& state_at, const Asked& asked, double contact_distance,
                                   const SaidContact& said) {
  for (int i = 0; i < kSamples && said.t_free > said.begin; ++i) {
    const double time = said.begin + (said.t_free - said.begin) * i / kSamples;
    const SignedDistance truth = closestIn(state_at(time), asked).result;
    if (truth.upper_bound < contact_distance - kTolerance) {
      return because("free until ", said.t_free, ", but ", truth.distance, " away at ", time);
    }
  }
  if (!said.contact) return {};
  const SignedDistance truth = closestIn(state_at(said.t_contact), asked).result;
  if (truth.lower_bound > contact_distance + kMotionTolerance + kTolerance) {
    return because("contact at ", said.t_contact, ", but ", truth.distance, " away");
  }
  return {};
}

/// No sample is closer than the lower bound, and the upper one is reached.
Verdict AnswerChecks::checkMinimum(const StateAt& state_at, const Asked& asked, const SaidMinimum& said) {
  const MotionMinimum& minimum = said.minimum;
  if (std::isnan(minimum.lower_bound)) return {};
  for (int i = 0; i <= kSamples; ++i) {
    const double time = said.begin + (said.end - said.begin) * i / kSamples;
    const SignedDistance truth = closestIn(state_at(time), asked).result;
    if (truth.upper_bound < minimum.lower_bound - kTolerance) {
      return because("at least ", minimum.lower_bound, " away, but ", truth.distance, " at ", time);
    }
  }
  if (!std::isfinite(minimum.upper_bound) || !std::isfinite(minimum.time)) return {};
  const SignedDistance truth = closestIn(state_at(minimum.time), asked).result;
  if (truth.lower_bound > minimum.upper_bound + kTolerance) {
    return because("at most ", minimum.upper_bound, " away at ", minimum.time, ", but ", truth.distance);
  }
  return {};
}

Verdict AnswerChecks::check(const FirstContactRequest& request, const FirstContactResponse& response) {
  const std::vector<double> start = robot_.positionsAt(response.header.stamp);
  sensor_msgs::JointState velocity = request.joints;
  velocity.position = velocity.velocity;
  const std::vector<double> velocities = positionsOf(velocity);
  const std::vector<Joint>& joints = robot_.robot().joints;
  const StateAt state_at = [&](double time) {
    std::vector<double> positions = start;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const double lower = std::min(joints[i].lower, start[i]), upper = std::max(joints[i].upper, start[i]);
      positions[i] = std::clamp(start[i] + time * velocities[i], lower, upper);
    }
    return positions;
  };
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto& said = response.joints_at_limit;
    const auto place = static_cast<std::size_t>(std::find(said.begin(), said.end(), joints[i].name) - said.begin());
    if (place == said.size()) continue;
    const double time = response.limit_times[place], end = state_at(request.horizon)[i];
    if (std::abs(start[i] + time * velocities[i] - end) > kTolerance)
      return because(joints[i].name, " stops at ", time, ", and that is not at ", end);
  }
  const Asked asked{request.a, request.b};
  const SaidContact said{0.0, response.contact != 0, response.t_free, response.t_contact};
  const Verdict verdict = checkContact(state_at, asked, request.contact_distance, said);
  return verdict.empty() ? checkMinimum(state_at, asked, {0.0, request.horizon, response.minimum}) : verdict;
}

Verdict AnswerChecks::check(const QueryTrajectoryRequest& request, const QueryTrajectoryResponse& response) {
  const auto& points = request.trajectory.points;
  const auto time_of = [&](std::size_t i) { return points[i].time_from_start.toSec(); };
  const StateAt state_at = [&](double time) {
    std::size_t i = 0;
    while (i + 2 < points.size() && time_of(i + 1) <= time) ++i;
    const double way = (time - time_of(i)) / (time_of(i + 1) - time_of(i));
    sensor_msgs::JointState state;
    state.name = request.trajectory.joint_names;
    for (std::size_t joint = 0; joint < state.name.size(); ++joint) {
      const double from = points[i].positions[joint], to = points[i + 1].positions[joint];
      state.position.push_back(from + way * (to - from));
    }
    return positionsOf(state);
  };
  const Asked asked{request.a, request.b};
  const SaidContact said{time_of(0), response.contact != 0, response.t_free, response.t_contact};
  const Verdict verdict = checkContact(state_at, asked, request.contact_distance, said);
  if (!verdict.empty()) return verdict;
  for (std::size_t i = 0; i < response.segments.size(); ++i) {
    const Verdict of_segment = checkMinimum(state_at, asked, {time_of(i), time_of(i + 1), response.segments[i]});
    if (!of_segment.empty()) return because("segment ", i, ": ", of_segment);
  }
  return {};
}

/// Checks the closest pair of a kind in a message of a cycle.
Verdict AnswerChecks::checkKind(PairKind kind, const Proximity& said) {
  const bool is_none = kind == PairKind::WithObject && (!scene_.objects() || scene_.objects()->pairCount() == 0);
  if (is_none) return said.state == Proximity::UNKNOWN ? Verdict() : because("there is no pair with an object");
  return agreement(said, *scene_.minimum(Pairs(scene_.candidates(), kind)));
}

Verdict AnswerChecks::check(const Clearance& clearance, const Levels& levels) {
  place(clearance.header.stamp);
  const PairProximity truth = *scene_.minimum(scene_.candidates());
  const double distance = truth.result.distance;
  Verdict verdict = agreement(clearance.minimum, truth);
  if (verdict.empty()) verdict = checkKind(PairKind::OfLinks, clearance.self_minimum);
  if (verdict.empty()) verdict = checkKind(PairKind::WithObject, clearance.object_minimum);
  if (!verdict.empty()) return verdict;
  const std::uint8_t least = distance < -kTolerance                ? Clearance::COLLISION
                             : distance < levels.stop - kTolerance ? Clearance::STOP
                             : distance < levels.warn - kTolerance ? Clearance::WARN
                                                                   : Clearance::CLEAR;
  if (clearance.level < least) return because("level ", int{clearance.level}, " at ", distance);

  const std::size_t listed = clearance.below_threshold.size();
  if (listed != std::min<std::size_t>(clearance.pairs_below_threshold, levels.most_listed))
    return because(listed, " listed of ", clearance.pairs_below_threshold);
  QueryPairsRequest request;
  request.mode = QueryPairsRequest::K_CLOSEST;
  request.k = static_cast<std::uint32_t>(listed);
  const Verdict list = listed > 0 ? checkPosed(request, clearance.below_threshold) : Verdict();
  return list.empty() ? checkNumberBelow(levels.listed, clearance.pairs_below_threshold) : list;
}

}  // namespace proximity_server::node
