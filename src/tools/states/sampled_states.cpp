#include "tools/states/sampled_states.h"

#include "tools/text/content_hash.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <Random123/philox.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

std::uint32_t low(std::uint64_t number) { return static_cast<std::uint32_t>(number); }
std::uint32_t high(std::uint64_t number) { return static_cast<std::uint32_t>(number >> 32); }

double fraction(std::uint32_t low_word, std::uint32_t high_word) {
  const std::uint64_t bits = std::uint64_t{high_word} << 32 | low_word;
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// The minimum is for sums that rounding puts beyond the range.
double positionAt(const scene::JointRange& range, double fraction) {
  return std::min(range.lower + fraction * range.width(), range.upper);
}

}  // namespace

std::array<double, 2> uniformNumbers(std::uint64_t seed, std::uint64_t state, std::uint32_t draw,
                                     std::uint32_t attempt) {
  const r123::Philox4x32::ctr_type counter{{low(state), high(state), draw, attempt}};
  const r123::Philox4x32::key_type key{{low(seed), high(seed)}};
  const r123::Philox4x32::ctr_type words = r123::Philox4x32()(counter, key);
  return {fraction(words[0], words[1]), fraction(words[2], words[3])};
}

SampledStates::SampledStates(std::uint64_t count, std::uint64_t seed, const scene::RobotModel& robot)
    : StateSource("--sample " + std::to_string(count) + " --seed " + std::to_string(seed), robot),
      count_(count),
      seed_(seed),
      ranges_(scene::jointRanges(robot)) {
  for (const scene::JointRange& range : ranges_) {
    if (std::isfinite(range.width())) continue;
    throw std::invalid_argument(header_.source + ": joint \"" + robot.joints[range.joint].name +
                                "\": its limits are too wide");
  }
  for (const std::string& sentence : guessedRanges(robot, ranges_)) header_.warn(sentence);
}

bool SampledStates::next(scene::TrajectoryPoint& state) {
  if (this->state() >= count_) return false;
  clear(state);
  naming(header_.source, [&] {
    scene::drawWithin(header_.robot.inequalities, state.positions,
                      [&](std::uint32_t attempt) { draw(attempt, state.positions); });
  });
  passState();
  return true;
}

void SampledStates::draw(std::uint32_t attempt, scene::Positions& positions) const {
  for (std::size_t first = 0; first < ranges_.size(); first += 2) {
    const std::array<double, 2> numbers =
        uniformNumbers(seed_, state(), static_cast<std::uint32_t>(first / 2), attempt);
    positions[ranges_[first].joint] = positionAt(ranges_[first], numbers[0]);
    if (first + 1 < ranges_.size()) positions[ranges_[first + 1].joint] = positionAt(ranges_[first + 1], numbers[1]);
  }
}

std::string SampledStates::identity() const {
  ContentHash ranges;
  for (const scene::JointRange& range : ranges_)
    ranges.add(header_.robot.joints[range.joint].name).add(shortest(range.lower)).add(shortest(range.upper));
  for (const scene::JointInequality& inequality : header_.robot.inequalities) ranges.add(inequality.text);
  return "sample " + std::to_string(count_) + " " + std::to_string(seed_) + " " + ranges.text();
}

std::vector<std::string> guessedRanges(const scene::RobotModel& robot, const std::vector<scene::JointRange>& ranges) {
  std::vector<std::string> sentences;
  for (const scene::JointRange& range : ranges) {
    if (scene::hasKnownRange(robot, range.joint)) continue;
    sentences.push_back("joint \"" + robot.joints[range.joint].name + "\" has no limits: from " +
                        shortest(range.lower) + " m to " + shortest(range.upper) + " m is a guess.");
  }
  return sentences;
}

}  // namespace proximity_server::tools
