#include "tools/states/grid_states.h"

#include "tools/states/joint_columns.h"
#include "tools/states/sampled_states.h"
#include "tools/text/content_hash.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

constexpr std::uint64_t kMostPositions = std::uint64_t{1} << 53;  // whole numbers that a double has

[[noreturn]] void failIn(const std::string& text, const std::string& what) {
  throw std::invalid_argument("'" + text + "': " + what);
}

/// Reads an end of the axis.
double readPosition(const std::string& text, const std::string& position, GridAxis& axis) {
  const std::optional<system::PositionText> value = system::positionIn(position);
  if (!value) failIn(text, scene::quoted(position) + " is no finite number, nor an angle like 90deg");
  axis.is_in_degrees = axis.is_in_degrees || value->is_in_degrees;
  return value->value;
}

std::uint64_t readPositions(const std::string& text, const std::string& number) {
  const auto value = numberIn<std::uint64_t>(number);
  if (!value || *value < 1 || *value > kMostPositions)
    failIn(text,
           scene::quoted(number) + " is no whole number of positions from 1 to " + std::to_string(kMostPositions));
  return *value;
}

/// Whether the range of a joint is a full turn, so that its ends are the same.
bool isFullTurn(const scene::Joint& joint, const scene::JointRange& range) {
  if (joint.type == scene::Joint::Type::Prismatic) return false;
  return !(range.width() >= joint.upper - joint.lower);
}

}  // namespace

GridAxis readGridAxis(const std::string& text) {
  GridAxis axis;
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos) {
    axis.count = readPositions(text, text);
    if (axis.count < 2) failIn(text, "a grid of all joints has at least 2 positions of each");
    return axis;
  }
  axis.joint = text.substr(0, equals);
  if (axis.joint.empty()) failIn(text, "there is no joint");
  const std::string values = text.substr(equals + 1);
  const std::size_t first = values.find(':'), second = values.find(':', first == std::string::npos ? first : first + 1);
  axis.lower = axis.upper = readPosition(text, values.substr(0, first), axis);
  axis.count = 1;
  if (first == std::string::npos) return axis;
  if (second == std::string::npos) failIn(text, "expected JOINT=LOWER:UPPER:COUNT, JOINT=POSITION or COUNT");
  axis.upper = readPosition(text, values.substr(first + 1, second - first - 1), axis);
  axis.count = readPositions(text, values.substr(second + 1));
  if (axis.count == 1) failIn(text, "from one end to the other are at least 2 positions");
  if (!(axis.lower < axis.upper)) failIn(text, "the lower end is not below the upper one");
  if (!std::isfinite(axis.upper - axis.lower)) failIn(text, "too wide");
  return axis;
}

GridStates::GridStates(const std::vector<GridAxis>& axes, const scene::RobotModel& robot)
    : StateSource("--grid", robot) {
  const bool has_all = std::any_of(axes.begin(), axes.end(), [](const GridAxis& axis) { return axis.joint.empty(); });
  if (has_all && axes.size() > 1) throw std::invalid_argument("--grid: a number for all joints stands alone");
  for (const GridAxis& axis : axes) {
    if (axis.joint.empty()) {
      addAll(axis.count);
    } else {
      addNamed(axis);
    }
  }
  countStates();
}

void GridStates::addNamed(const GridAxis& axis) {
  naming("--grid: joint " + scene::quoted(axis.joint), [&] {
    const int joint = jointWithPosition(axis.joint, header_.robot);
    if (const std::string reason = whyNotUsed(header_.robot, joint); !reason.empty())
      throw std::invalid_argument(reason);
    if (axis.is_in_degrees && header_.robot.joints[joint].type == scene::Joint::Type::Prismatic)
      throw std::invalid_argument("it is prismatic: its positions are in metres");
    if (std::any_of(header_.columns.begin(), header_.columns.end(),
                    [&](const JointColumn& other) { return other.joint == joint; }))
      throw std::invalid_argument("named twice");
    add(joint, {axis.lower, axis.upper, axis.count, axis.count - 1});
  });
}

void GridStates::addAll(std::uint64_t count) {
  const std::vector<scene::JointRange> ranges = scene::jointRanges(header_.robot);
  if (ranges.empty()) throw std::invalid_argument("--grid: the robot has no joint that moves");
  for (const scene::JointRange& range : ranges) {
    const scene::Joint& joint = header_.robot.joints[range.joint];
    if (!std::isfinite(range.width()))
      throw std::invalid_argument("--grid: joint " + scene::quoted(joint.name) + ": its limits are too wide");
    const std::uint64_t positions = range.width() > 0.0 ? count : 1;
    const std::uint64_t intervals = isFullTurn(joint, range) ? positions : positions - 1;
    add(range.joint, {range.lower, range.upper, positions, intervals});
  }
  for (const std::string& sentence : guessedRanges(header_.robot, ranges)) header_.warn(sentence);
}

void GridStates::add(int joint, const Axis& axis) {
  header_.columns.push_back({header_.robot.joints[joint].name, joint});
  axes_.push_back(axis);
  numbers_.push_back(axis.position());
}

void GridStates::countStates() {
  for (const Axis& axis : axes_) {
    if (!__builtin_mul_overflow(count_, axis.count, &count_) &&
        count_ <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
      continue;
    throw std::invalid_argument("--grid: more states than a number of 64 bits can count");
  }
}

double GridStates::Axis::position() const {
  if (index == 0) return lower;
  if (index == intervals) return upper;
  const double step = (upper - lower) / static_cast<double>(intervals);
  return std::min(lower + static_cast<double>(index) * step, upper);
}

std::optional<const double*> GridStates::fetch() {
  if (state() >= count_) return std::nullopt;
  // The steps that are left for an axis, once the axes behind it have made theirs: one, or many after skipTo().
  std::uint64_t steps = state() - at_;
  at_ = state();
  for (std::size_t i = axes_.size(); i-- > 0 && steps > 0;) {
    Axis& axis = axes_[i];
    axis.index += steps;
    steps = axis.index < axis.count ? 0 : axis.index / axis.count;
    if (steps > 0) axis.index %= axis.count;
    numbers_[i] = axis.position();
  }
  return numbers_.data();
}

std::string GridStates::identity() const {
  ContentHash hash;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    hash.add(header_.columns[i].name).add(shortest(axes_[i].lower)).add(shortest(axes_[i].upper));
    hash.add(std::to_string(axes_[i].count)).add(std::to_string(axes_[i].intervals));
  }
  return "grid " + std::to_string(count_) + " " + hash.text();
}

}  // namespace proximity_server::tools
