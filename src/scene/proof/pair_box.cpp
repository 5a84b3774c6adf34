#include "scene/proof/pair_box.h"

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "scene/objects/placed_object.h"
#include "scene/state/part.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <variant>

namespace proximity_server::scene {
namespace {

std::string textOf(const ShapeRefPair& pair, const RobotModel& robot, const Objects* objects) {
  return nameOf(pair.a, robot, objects) + " - " + nameOf(pair.b, robot, objects);
}

int linkCarrying(const ShapeRef& ref, const RobotModel& robot, const Objects* objects) {
  const int links = static_cast<int>(robot.links.size());
  if (ref.isLink() && ref.link() < links) return ref.link();
  const Object* object =
      ref.isObject() && objects && ref.object() < objects->numberLimit() ? objects->object(ref.object()) : nullptr;
  if (!object) throw std::invalid_argument("a pair names a link or an object that does not exist");
  return carryingLink(robot, *object);
}

void requireInterval(const JointBox& box, int joint, const RobotModel& robot, const std::string& pair) {
  const std::string name = "joint " + quoted(robot.joints[joint].name) + ", between " + pair + ", ";
  if (!hasOnePosition(robot.joints[joint]))
    throw std::invalid_argument(name + "is " + toString(robot.joints[joint].type) +
                                ": nothing can be proven of joints with more than one position");
  const JointRange* interval = intervalOf(box, joint);
  if (!interval) throw std::invalid_argument(name + "has no interval");
  if (!(interval->lower <= interval->upper) || !std::isfinite(interval->lower) || !std::isfinite(interval->upper))
    throw std::invalid_argument(name + "has no finite interval: it is from " + shortest(interval->lower) + " to " +
                                shortest(interval->upper));
}

/// [m] The largest distance of a point of the geometry from the frame of what carries it.
double reachOf(const ShapeRef& ref, const RobotModel& robot, const Objects* objects) {
  if (ref.isLink()) return robot.reachOf(ref.link(), Eigen::Vector3d::Zero());
  const PlacedObject& placed = *objects->placed(ref.object());
  double reach = 0.0;  // a half-space counts as far as the other shape reaches
  if (!placed.isUnbounded()) {
    const Bounds& bounds = partOf(placed).whole().bounds;
    reach = bounds.centre.norm() + bounds.radius;
  }
  return reach + std::visit(
                     [](const auto& at) -> double {
                       using At = std::decay_t<decltype(at)>;
                       if constexpr (std::is_same_v<At, Fixed>) return at.world_T_object.translation().norm();
                       if constexpr (std::is_same_v<At, Moving>) return at.frame_T_object.translation().norm();
                       if constexpr (std::is_same_v<At, Attached>) return at.link_T_object.translation().norm();
                     },
                     placed.object.placement);
}

/// Sums over the joints from the root to a body: their lengths [m], and what their positions do to the rounding.
struct Path {
  double lengths = 0.0, joints = 0.0;
};

Path pathTo(int body, const RobotModel& robot, const JointBox& box) {
  Path path;
  for (; robot.bodies[body].joint >= 0; body = robot.bodies[body].parent) {
    const Joint& joint = robot.joints[robot.bodies[body].joint];
    const Joint::Mimic leader = robot.leaderOf(robot.bodies[body].joint);
    const JointRange* interval = intervalOf(box, leader.joint);
    const double largest = interval ? std::max(std::abs(interval->lower), std::abs(interval->upper)) : 0.0;
    const double position = std::abs(leader.offset) + std::abs(leader.multiplier) * largest;
    path.lengths +=
        robot.links[joint.parent_link].body_T_link.translation().norm() + joint.parent_T_joint.translation().norm();
    if (joint.type == Joint::Type::Prismatic) path.lengths += position;
    path.joints += 1.0 + position;
  }
  return path;
}

}  // namespace

PairBox pairBox(const RobotModel& robot, const Objects* objects, const ShapeRefPair& pair, const JointBox& box) {
  const int body_a = robot.links[linkCarrying(pair.a, robot, objects)].body;
  const int body_b = robot.links[linkCarrying(pair.b, robot, objects)].body;
  std::set<int> leaders;
  for (const int joint : jointsBetween(robot, body_a, body_b)) leaders.insert(robot.leaderOf(joint).joint);
  PairBox result;
  for (const int leader : leaders) {
    requireInterval(box, leader, robot, textOf(pair, robot, objects));
    result.joints.push_back(*intervalOf(box, leader));
  }
  const Path a = pathTo(body_a, robot, box), b = pathTo(body_b, robot, box);
  const double lengths = a.lengths + b.lengths + reachOf(pair.a, robot, objects) + reachOf(pair.b, robot, objects);
  const double joints = 1.0 + a.joints + b.joints;
  result.rounding = 128.0 * std::numeric_limits<double>::epsilon() * (joints * lengths);
  return result;
}

}  // namespace proximity_server::scene
