#include "tools/states/recorded_states.h"

#include "tools/states/joint_columns.h"
#include "tools/text/content_hash.h"
#include "tools/text/csv.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
void JointRecording::add(double time, const std::vector<std::string>& names, const std::vector<double>& positions) {
  if (positions.empty()) return;
  if (positions.size() != names.size()) {
    throw std::invalid_argument(std::to_string(positions.size()) + " positions for " + std::to_string(names.size()) +
                                " names");
  }
  const std::size_t begin = positions_.size();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int joint = jointOf(names[i]);
    if (joint == kNotUsed) continue;
    if (!std::isfinite(positions[i]))
      throw std::invalid_argument("joint " + scene::quoted(names[i]) + ": " + scene::quoted(shortest(positions[i])) +
                                  " is no finite number");
    for (std::size_t other = begin; other < positions_.size(); ++other)
      if (positions_[other].joint == joint)
        throw std::invalid_argument("joint " + scene::quoted(names[i]) + " is named twice");
    positions_.push_back({joint, positions[i]});
  }
  if (positions_.size() > begin) messages_.push_back({time, begin, positions_.size()});
}

/// The joint, or kNotUsed.
int JointRecording::jointOf(const std::string& name) {
  const auto known = joints_.find(name);
  if (known != joints_.end()) return known->second;
  int joint = kNotUsed;
  std::string reason;
  try {
    joint = jointWithPosition(name, robot_);
    reason = whyNotUsed(robot_, joint);
  } catch (const std::invalid_argument& error) {
    reason = error.what();
  }
  if (!reason.empty()) {
    joint = kNotUsed;
    left_out_.push_back("joint " + scene::quoted(name) + " is not used: " + reason + ".");
  }
  return joints_[name] = joint;
}

RecordedStates::RecordedStates(std::string source, const JointRecording& recording, std::optional<double> rate)
    : StateSource(std::move(source), recording.robot_), rate_(rate) {
  for (const std::string& sentence : recording.left_out_) header_.warn(sentence);
  if (recording.messages_.empty())
    throw std::invalid_argument(header_.source + ": no message has the position of a joint of the robot" +
                                (recording.left_out_.empty() ? "" : "; " + recording.left_out_.front()));
  addStates(recording);
  if (rate_) countTicks();
}

void RecordedStates::addStates(const JointRecording& recording) {
  std::vector<JointRecording::Message> messages = recording.messages_;
  std::stable_sort(messages.begin(), messages.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  std::set<int> unknown;
  for (const JointRecording::Position& position : recording.positions_) unknown.insert(position.joint);
  header_.columns.push_back({"time", -1, JointColumn::Quantity::Time});
  for (const int joint : unknown) header_.columns.push_back({header_.robot.joints[joint].name, joint});
  scene::Positions now(header_.robot.joints.size(), 0.0);
  int last = -1;  // the joint that becomes known last
  std::size_t left_out = 0;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    for (std::size_t place = messages[i].begin; place < messages[i].end; ++place) {
      const JointRecording::Position& position = recording.positions_[place];
      now[position.joint] = position.value;
      if (unknown.erase(position.joint) > 0) last = position.joint;
    }
    if (i + 1 < messages.size() && messages[i + 1].time == messages[i].time) continue;
    if (!unknown.empty()) {
      ++left_out;
      continue;
    }
    times_.push_back(messages[i].time);
    for (const JointColumn& column : header_.columns)
      states_.push_back(column.quantity == JointColumn::Quantity::Time ? messages[i].time : now[column.joint]);
  }
  if (left_out == 0) return;
  header_.warn("the states of the first " + std::to_string(left_out) + " times are left out: joint " +
               scene::quoted(header_.robot.joints[last].name) + " is not known before " + shortest(times_.front()) +
               " s.");
}

/// Counts the ticks up to the last message, by the rounded times that tick() gives.
void RecordedStates::countTicks() {
  ticks_ = static_cast<std::uint64_t>((times_.back() - times_.front()) * *rate_) + 1;
  while (tick(ticks_) <= times_.back()) ++ticks_;
  while (tick(ticks_ - 1) > times_.back()) --ticks_;
}

double RecordedStates::tick(std::uint64_t number) const {
  return times_.front() + static_cast<double>(number) / *rate_;
}

std::optional<const double*> RecordedStates::fetch() {
  if (state() >= *count()) return std::nullopt;
  std::size_t row = state();
  if (rate_) {
    const auto later = std::upper_bound(times_.begin(), times_.end(), tick(state()));
    row = static_cast<std::size_t>(later - times_.begin()) - 1;
  }
  double* const found = states_.data() + row * header_.columns.size();
  if (rate_) *found = tick(state());
  return last_ = found;
}

std::string RecordedStates::identity() const {
  const std::size_t width = header_.columns.size(), joints = width - 1;
  ContentHash hash;
  for (std::size_t i = 1; i < width; ++i) hash.add(header_.columns[i].name);
  hash.add(times_.data(), times_.size() * sizeof(double));
  for (std::size_t row = 0; row < times_.size(); ++row)
    hash.add(states_.data() + row * width + 1, joints * sizeof(double));
  return "recorded " + hash.text() + " " + (rate_ ? shortest(*rate_) : "every");
}

std::string RecordedStates::place() const {
  const std::string place = StateSource::place();
  return last_ ? place + " at " + shortest(*last_) + " s" : place;
}

}  // namespace proximity_server::tools
