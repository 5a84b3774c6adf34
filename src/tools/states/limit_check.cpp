#include "tools/states/limit_check.h"

#include <algorithm>
#include <cmath>

#include "tools/command_line/csv.h"

namespace proximity_server::tools {
namespace {

constexpr double kPi = 3.14159265358979323846;

bool isBeyond(const scene::Joint& joint, double position) {
  return position < joint.lower - kLimitRounding || position > joint.upper + kLimitRounding;
}

}  // namespace

void LimitCheck::beginState(std::uint64_t state, long line) {
  ++states_;
  state_ = state;
  line_ = line;
  is_beyond_ = false;
}

void LimitCheck::add(int joint, double position) {
  const scene::Joint& limits = robot_.joints[joint];
  if (limits.mimic || !isBeyond(limits, position)) return;
  if (!is_beyond_) ++states_beyond_;
  is_beyond_ = true;
  if (!first_) first_ = Violation{state_, line_, joint, position};
  if (limits.type != scene::Joint::Type::Revolute) return;
  largest_angle_ = std::max(largest_angle_, std::abs(position));
  would_be_within_as_degrees_ = would_be_within_as_degrees_ && !isBeyond(limits, position * kPi / 180.0);
}

/// Positions look like degrees only if one exceeds a full turn, which hardly any joint makes.
bool LimitCheck::looksLikeDegrees() const { return largest_angle_ > 2.0 * kPi && would_be_within_as_degrees_; }

std::string LimitCheck::warning(const std::string& source) const {
  if (!first_) return "";
  const scene::Joint& joint = robot_.joints[first_->joint];
  const std::string unit = joint.type == scene::Joint::Type::Prismatic ? " m" : " rad";
  std::string text = source + ": " + std::to_string(states_beyond_) + " of " + std::to_string(states_) +
                     " states are beyond the limits of a joint. The first is state " + std::to_string(first_->state) +
                     (first_->line > 0 ? ", line " + std::to_string(first_->line) : "") + ": \"" + joint.name +
                     "\" is at " + numberText(first_->position) + unit + ", its limits are " + numberText(joint.lower) +
                     " and " + numberText(joint.upper) + unit + ".";
  if (looksLikeDegrees()) {
    text +=
        " These look like degrees, which are the usual cause: as such, all angles would be within their limits. "
        "Positions are in radians.";
  }
  return text;
}

}  // namespace proximity_server::tools
