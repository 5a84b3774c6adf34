#include "proximity_server/scene/uncertainty/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

// `what` returns the name, which costs more than the check.
template <typename Name>
void requireBound(double value, const Name& what) {
  if (!(value >= 0.0) || !std::isfinite(value))
    throw std::invalid_argument("the uncertainty of " + what() + " is " + std::to_string(value) +
                                ", but must be finite and not negative");
}

template <typename Name>
void requireBounds(const PoseUncertainty& pose, const Name& whose) {
  requireBound(pose.translation, [&] { return "the translation of " + whose(); });
  requireBound(pose.angle, [&] { return "the angle of " + whose(); });
}

void requireCount(std::size_t count, std::size_t wanted, const char* what) {
  if (count != wanted)
    throw std::invalid_argument("the robot has " + std::to_string(wanted) + " " + what +
                                ", but there are uncertainties of " + std::to_string(count));
}

}  // namespace

Uncertainty::Uncertainty(const RobotModel& robot)
    : positions(robot.joints.size(), 0.0),
      frames(robot.joints.size()),
      bases(robot.robots.size()),
      swellings(robot.links.size(), 0.0) {}

const PoseUncertainty& Uncertainty::ofObject(const std::string& id) const {
  const auto own = own_objects.find(id);
  return own == own_objects.end() ? objects : own->second;
}

bool Uncertainty::isZero() const {
  const auto is_zero = [](double bound) { return bound == 0.0; };
  const auto is_exact = [](const PoseUncertainty& pose) { return pose.isZero(); };
  return std::all_of(positions.begin(), positions.end(), is_zero) &&
         std::all_of(frames.begin(), frames.end(), is_exact) && std::all_of(bases.begin(), bases.end(), is_exact) &&
         std::all_of(swellings.begin(), swellings.end(), is_zero) && objects.isZero() &&
         std::all_of(own_objects.begin(), own_objects.end(), [](const auto& own) { return own.second.isZero(); });
}

void Uncertainty::requireValidFor(const RobotModel& robot) const {
  requireCount(positions.size(), robot.joints.size(), "joints");
  requireCount(frames.size(), robot.joints.size(), "joints");
  requireCount(bases.size(), robot.robots.size(), "bases");
  requireCount(swellings.size(), robot.links.size(), "links");
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    requireBound(positions[i], [&] { return "the position of joint \"" + joint.name + "\""; });
    if (positions[i] > 0.0 && !hasOnePosition(joint))
      throw std::invalid_argument("joint \"" + joint.name + "\" is " + toString(joint.type) +
                                  " and has no position that can be uncertain: state the uncertainty of its frame");
    requireBounds(frames[i], [&] { return "the frame of joint \"" + joint.name + "\""; });
  }
  for (std::size_t i = 0; i < bases.size(); ++i) {
    const std::string& name = robot.robots[i].name;
    requireBounds(bases[i], [&] { return name.empty() ? "the base" : "the base of robot \"" + name + "\""; });
  }
  for (std::size_t i = 0; i < swellings.size(); ++i)
    requireBound(swellings[i], [&] { return "the surface of link \"" + robot.links[i].name + "\""; });
  requireBounds(objects, [] { return std::string("objects"); });
  for (const auto& own : own_objects) requireBounds(own.second, [&] { return "object \"" + own.first + "\""; });
}

}  // namespace proximity_server::scene
