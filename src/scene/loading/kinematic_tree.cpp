#include "scene/loading/kinematic_tree.h"

#include "proximity_server/scene/model/names.h"
#include "scene/loading/collision_geometry.h"
#include "scene/mesh/input_limits.h"
#include "scene/model/numbers.h"
#include "system/append.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Joint::Type typeOf(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
      return Joint::Type::Revolute;
    case urdf::Joint::CONTINUOUS:
      return Joint::Type::Continuous;
    case urdf::Joint::PRISMATIC:
      return Joint::Type::Prismatic;
    case urdf::Joint::FLOATING:
      return Joint::Type::Floating;
    case urdf::Joint::PLANAR:
      return Joint::Type::Planar;
    default:
      throw std::invalid_argument("URDF: joint " + quoted(joint.name) + " is of no known type");
  }
}

Vector3d axisOf(const urdf::Joint& joint) {
  if (joint.type == urdf::Joint::FLOATING) return Vector3d::UnitZ();
  Vector3d axis = Vector3d(joint.axis.x, joint.axis.y, joint.axis.z).stableNormalized();
  if (!(axis.norm() > 0.5)) {
    throw std::invalid_argument("URDF: joint " + quoted(joint.name) + " has an axis of length zero");
  }
  return axis;
}

/// The pose of a joint in its parent link.
Isometry3d originOf(const urdf::Joint& joint) {
  const Isometry3d origin = toEigen(joint.parent_to_joint_origin_transform);
  // Written as !(norm <= farthest) so that NaN is refused too.
  if (!origin.matrix().allFinite() || !(origin.translation().norm() <= kFarthest)) {
    throw std::invalid_argument("URDF: joint " + quoted(joint.name) + " has an <origin> that is not finite, or " +
                                kTooFar + " from its parent");
  }
  return origin;
}

Joint readJoint(const urdf::Joint& joint, int parent_link, int child_link, std::vector<std::string>& warnings) {
  Joint result{joint.name,    typeOf(joint), parent_link, child_link, originOf(joint),
               axisOf(joint), -kInfinity,    kInfinity,   kInfinity,  std::nullopt};
  if (!joint.limits) return result;
  // Many URDFs write 0 for an unknown velocity; a joint that must not move would be a fixed joint.
  if (joint.limits->velocity > 0) result.max_velocity = joint.limits->velocity;
  if (result.type != Joint::Type::Revolute && result.type != Joint::Type::Prismatic) return result;
  if (joint.limits->lower > joint.limits->upper) {
    warnings.push_back("joint " + quoted(joint.name) + ": its lower limit is above the upper one; taken as unlimited.");
    return result;
  }
  if (joint.limits->lower >= -kFarthest) result.lower = joint.limits->lower;
  if (joint.limits->upper <= kFarthest) result.upper = joint.limits->upper;
  if (std::isinf(result.lower) || std::isinf(result.upper)) {
    warnings.push_back("joint " + quoted(joint.name) + ": a limit beyond 1e6; taken as none.");
  }
  return result;
}

/// Adds a link. It belongs to the body of its parent, or, below a movable joint, to a body of its own. Returns its
/// index.
int addLink(const urdf::Link& link, int parent_link, RobotModel& model) {
  const int index = system::append(model.links, Link{link.name, -1, Isometry3d::Identity(), {}, parent_link});
  Link& added = model.links[index];
  if (parent_link < 0) {
    added.body = system::append(model.bodies, Body{index, -1, -1, {}, {}});
  } else if (const urdf::Joint& joint = *link.parent_joint; joint.type == urdf::Joint::FIXED) {
    const Link& parent = model.links[parent_link];
    added.body = parent.body;
    added.body_T_link = parent.body_T_link * originOf(joint);
    model.fixed_joints.push_back(joint.name);
  } else {
    const int carrier = system::append(model.joints, readJoint(joint, parent_link, index, model.warnings));
    added.body = system::append(model.bodies, Body{index, carrier, model.links[parent_link].body, {}, {}});
  }
  model.bodies[added.body].links.push_back(index);
  return index;
}

/// Adds links, joints and bodies, depth first from the root, so that parents come first.
void addTree(const urdf::ModelInterface& urdf, RobotModel& model) {
  struct Pending {
    urdf::LinkConstSharedPtr link;
    int parent;
  };
  std::vector<Pending> pending{{urdf.getRoot(), -1}};
  while (!pending.empty()) {
    const Pending next = pending.back();
    pending.pop_back();
    const int index = addLink(*next.link, next.parent, model);
    const auto& children = next.link->child_links;
    for (auto child = children.rbegin(); child != children.rend(); ++child) pending.push_back({*child, index});
  }
}

/// Returns why the chain of joints that a joint mimics is invalid, or "" if it is valid.
std::string faultOfMimic(const RobotModel& model, int joint) {
  int follower = joint;
  for (std::size_t steps = 0; model.joints[follower].mimic; ++steps) {
    if (steps == model.joints.size()) return "mimics itself in a circle";
    follower = model.joints[follower].mimic->joint;
  }
  // Multipliers and offsets multiply along the chain. Written as !(x <= farthest) so that NaN is refused too.
  const Joint::Mimic leader = model.leaderOf(joint);
  const bool is_small = std::abs(leader.multiplier) <= kFarthest && std::abs(leader.offset) <= kFarthest;
  return is_small ? "" : "mimics with a multiplier or an offset beyond 1e6";
}

/// For each link: true if it has a <collision>, or a link below it has one.
std::vector<bool> linksThatCarryGeometry(const urdf::ModelInterface& urdf, const RobotModel& model) {
  std::vector<bool> carries;
  for (const Link& link : model.links) carries.push_back(!urdf.getLink(link.name)->collision_array.empty());
  for (std::size_t i = model.links.size(); i-- > 1;) {  // parents come first
    if (carries[i]) carries[model.links[i].parent] = true;
  }
  return carries;
}

/// Reads the mimic joints. If an invalid mimic moves geometry, it is an error unless the options allow it. Otherwise it
/// is a warning, and the joint has a position of its own.
class MimicReader {
 public:
  MimicReader(const urdf::ModelInterface& urdf, const ModelOptions& options, RobotModel& model)
      : urdf_(urdf), options_(options), model_(model), carries_geometry_(linksThatCarryGeometry(urdf, model)) {}

  void readAll() {
    for (Joint& joint : model_.joints) read(joint);
    // all faults are collected first, because another mimic may look valid after one is removed
    std::vector<std::pair<int, std::string>> faults;
    for (int i = 0; i < static_cast<int>(model_.joints.size()); ++i) {
      if (const std::string fault = faultOfMimic(model_, i); !fault.empty()) faults.emplace_back(i, fault);
    }
    for (const auto& [joint, fault] : faults) refuse(model_.joints[joint], fault);
  }

 private:
  void read(Joint& joint) {
    const auto& mimic = urdf_.getJoint(joint.name)->mimic;
    if (!mimic) return;
    if (!urdf_.getJoint(mimic->joint_name)) {
      return refuse(joint, "mimics the unknown joint " + unknownName(mimic->joint_name, namesOf(model_.joints)));
    }
    const int leader = findNamed(model_.joints, mimic->joint_name);
    if (leader < 0 || !hasOnePosition(model_.joints[leader]) || !hasOnePosition(joint)) {
      return refuse(joint, "mimics joint " + quoted(mimic->joint_name) +
                               ", but one of the two is fixed, planar or floating, and so has no position");
    }
    joint.mimic = Joint::Mimic{leader, mimic->multiplier, mimic->offset};
  }

  void refuse(Joint& joint, const std::string& fault) {
    const bool carries_geometry = carries_geometry_[joint.child_link];
    if (carries_geometry && !options_.allow_broken_mimics) {
      throw std::invalid_argument("URDF: joint " + quoted(joint.name) + " " + fault +
                                  "; with allow_broken_mimics it is a joint of its own");
    }
    joint.mimic.reset();
    warn(joint, fault + (carries_geometry ? "" : ", but moves no geometry"));
  }

  void warn(const Joint& joint, const std::string& fault) {
    model_.warnings.push_back("joint " + quoted(joint.name) + " " + fault + "; taken as a joint of its own.");
  }

  const urdf::ModelInterface& urdf_;
  const ModelOptions& options_;
  RobotModel& model_;
  const std::vector<bool> carries_geometry_;
};

/// True if the limits of a revolute joint are hardly in radians, but usual in degrees: two turns or more, a multiple of
/// half a degree, and at most two turns in degrees. Joints that really turn so often mostly have limits that are
/// multiples of pi, or very large.
bool seemsInDegrees(const Joint& joint) {
  if (joint.type != Joint::Type::Revolute) return false;
  const double largest = std::max(std::abs(joint.lower), std::abs(joint.upper));
  const auto isHalves = [](double limit) { return limit * 2.0 == std::round(limit * 2.0); };
  constexpr double kTwoTurns = 12.566370614359172, kTwoTurnsInDegrees = 720.0;
  return largest >= kTwoTurns && largest <= kTwoTurnsInDegrees && isHalves(joint.lower) && isHalves(joint.upper);
}

void warnOfDegrees(RobotModel& model) {
  std::vector<std::string> joints;
  for (const Joint& joint : model.joints) {
    if (seemsInDegrees(joint))
      joints.push_back(quoted(joint.name) + " from " + shortest(joint.lower) + " to " + shortest(joint.upper));
  }
  if (joints.empty()) return;
  model.warnings.push_back("Limits that look like degrees, but count as radians: joint " + listed(joints) +
                           ". If they are in degrees, multiply them by pi / 180.");
}

}  // namespace

void addKinematicTree(const urdf::ModelInterface& urdf, const ModelOptions& options, RobotModel& model) {
  addTree(urdf, model);
  MimicReader(urdf, options, model).readAll();
  warnOfDegrees(model);
}

}  // namespace proximity_server::scene
