#include "proximity_server/scene/state/degrees_of_freedom.h"

namespace proximity_server::scene {
namespace {

using DegreeKind = DegreeOfFreedom::Kind;

struct Coordinate {
  const char* suffix;
  DegreeKind kind;
};

std::vector<Coordinate> coordinatesOf(Joint::Type type) {
  switch (type) {
    case Joint::Type::Revolute:
    case Joint::Type::Continuous:
      return {{"", DegreeKind::Rotation}};
    case Joint::Type::Prismatic:
      return {{"", DegreeKind::Translation}};
    case Joint::Type::Planar:
      return {{"/x", DegreeKind::Translation}, {"/y", DegreeKind::Translation}, {"/theta", DegreeKind::Rotation}};
    case Joint::Type::Floating:
      return {{"/trans_x", DegreeKind::Translation}, {"/trans_y", DegreeKind::Translation},
              {"/trans_z", DegreeKind::Translation}, {"/rot_x", DegreeKind::Rotation},
              {"/rot_y", DegreeKind::Rotation},      {"/rot_z", DegreeKind::Rotation}};
  }
  return {};
}

}  // namespace

DegreesOfFreedom::DegreesOfFreedom(const RobotModel& model) : of_joint_(model.joints.size()) {
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    if (joint.mimic) continue;
    of_joint_[i] = {size(), 0, 1.0};
    for (const Coordinate& coordinate : coordinatesOf(joint.type)) {
      list_.push_back({joint.name + coordinate.suffix, static_cast<int>(i), coordinate.kind});
      ++of_joint_[i].count;
    }
  }
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    if (!model.joints[i].mimic) continue;
    const Joint::Mimic leader = model.leaderOf(static_cast<int>(i));
    of_joint_[i] = of_joint_[leader.joint];
    of_joint_[i].multiplier = leader.multiplier;
  }
}

}  // namespace proximity_server::scene
