#include "node/answers/clearance_message.h"

#include "node/answers/gradients.h"
#include "node/answers/guarantees.h"
#include "node/answers/statuses.h"
#include "node/robot/query_status.h"

#include <algorithm>
#include <utility>

namespace proximity_server::node {
namespace {

const std::vector<double> kNotTold;

std::uint8_t levelCode(scene::ClearanceLevel level) {
  static_assert(Clearance::CLEAR == static_cast<std::uint8_t>(scene::ClearanceLevel::Clear) &&
                Clearance::WARN == static_cast<std::uint8_t>(scene::ClearanceLevel::Warn) &&
                Clearance::STOP == static_cast<std::uint8_t>(scene::ClearanceLevel::Stop) &&
                Clearance::COLLISION == static_cast<std::uint8_t>(scene::ClearanceLevel::Collision));
  return static_cast<std::uint8_t>(level);
}

}  // namespace

void ClearanceMessage::follow(const Robot& robot) {
  robot_ = &robot;
  text_.emplace(robot.robotModel());
}

void ClearanceMessage::use(std::uint64_t objects_revision, std::size_t longest_name) {
  message_.objects_revision = objects_revision;
  longest_name_ = longest_name;
  text_capacity_ = text_->capacity(longest_name);
}

Clearance& ClearanceMessage::write(const AssessedCycle& cycle) {
  begin(cycle);
  assignJoints(cycle);
  listPairs(cycle);
  assignCounts(cycle);
  if (cycle.found.level)
    assignLevel(cycle);
  else
    explainInvalid(cycle);
  return message_;
}

void ClearanceMessage::begin(const AssessedCycle& cycle) {
  message_.header.stamp = cycle.snapshot.stamp;
  message_.header.frame_id = robot_->referenceFrame();
  message_.status = cycle.snapshot.status;
  for (Proximity* pair : {&message_.deciding, &message_.minimum, &message_.self_minimum, &message_.object_minimum})
    assignUnknown(*pair);
  message_.level = Clearance::INVALID;
  message_.deciding_threshold = kNaN;
  message_.deciding_reached = false;
  message_.by_guaranteed = robot_->isUncertain();
  message_.tf_age = cycle.snapshot.age;
  message_.tf_skew = cycle.snapshot.skew;
  ++message_.cycle;
}

void ClearanceMessage::assignJoints(const AssessedCycle& cycle) {
  text_->move(cycle.snapshot.poses, cycle.snapshot.stamp);
  if (!cycle.settings.gradients) {
    message_.joint_names.clear();
    message_.joint_positions.clear();
    return;
  }
  assignColumns(message_.joint_names, cycle.state.degreesOfFreedom());
  assignPositions(message_.joint_positions, cycle.state, cycle.snapshot.poses);
}

void ClearanceMessage::assignCounts(const AssessedCycle& cycle) {
  const scene::PairTable& table = robot_->sceneModel().pairs;
  node::assignCounts(message_, cycle.found.counts);
  const std::uint64_t total = table.pairs.size() + static_cast<std::uint64_t>(cycle.state.objects()->pairCount());
  message_.pairs_total = static_cast<std::uint32_t>(std::min<std::uint64_t>(total, UINT32_MAX));
  message_.pairs_filtered = static_cast<std::uint32_t>(table.pairs.size() - table.checked.size());
}

void ClearanceMessage::listPairs(const AssessedCycle& cycle) {
  const auto most = static_cast<std::size_t>(cycle.settings.max_reported_pairs);
  std::vector<Proximity>& listed = message_.below_threshold;
  message_.pairs_below_threshold = static_cast<std::uint32_t>(cycle.found.below);
  listed.reserve(most);
  message_.levels.reserve(most);
  unlisted_.reserve(most);
  while (listed.size() + unlisted_.size() < most) unlisted_.emplace_back();
  for (Proximity& pair : unlisted_) reserve(pair, cycle);
  const std::size_t count = std::min(cycle.found.listed.size(), most);
  for (; listed.size() > count; listed.pop_back()) unlisted_.push_back(std::move(listed.back()));
  for (; listed.size() < count; unlisted_.pop_back()) listed.push_back(std::move(unlisted_.back()));
  message_.levels.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    assignPair(listed[i], cycle, cycle.found.listed[i], cycle.found.of_listed[i]);
    message_.levels[i] = levelCode(cycle.found.of_listed[i].level);
  }
}

/// Reserves as much memory as any pair needs.
void ClearanceMessage::reserve(Proximity& pair, const AssessedCycle& cycle) const {
  reserveNames(pair.a, longest_name_);
  reserveNames(pair.b, longest_name_);
  if (cycle.settings.gradients) pair.gradient.reserve(static_cast<std::size_t>(cycle.state.degreesOfFreedom().size()));
}

void ClearanceMessage::assignPair(Proximity& message, const AssessedCycle& cycle, const scene::PairProximity& pair,
                                  const scene::PairFacts& facts) const {
  reserve(message, cycle);
  assign(message, {robot_->robotModel(), cycle.state.objects().get()}, cycle.snapshot.poses, pair, {});
  message.guaranteed = facts.guaranteed;
  if (cycle.settings.gradients) message.gradient = facts.gradient;
}

void ClearanceMessage::assignPair(Proximity& message, const AssessedCycle& cycle,
                                  const scene::AssessedPair& pair) const {
  if (pair.pair.result.status != narrowphase::Status::Unknown) assignPair(message, cycle, pair.pair, pair);
}

void ClearanceMessage::assignLevel(const AssessedCycle& cycle) {
  const scene::Assessment& found = cycle.found;
  assignPair(message_.minimum, cycle, found.minimum);
  assignPair(message_.self_minimum, cycle, found.of_links.closest);
  assignPair(message_.object_minimum, cycle, found.with_object.closest);
  assignPair(message_.deciding, cycle, found.deciding);
  message_.deciding_threshold = found.level->threshold;
  message_.deciding_reached = found.reached;
  message_.level = levelCode(found.level->level);
  message_.status.code = statusCode(found.minimum.pair.result);
  explain(cycle);
}

/// Writes the text about the pair that sets the level. Far from all thresholds its motion does not matter.
void ClearanceMessage::explain(const AssessedCycle& cycle) {
  std::string& text = message_.status.message;
  text.reserve(text_capacity_);
  text_->write(text, message_, message_.level == Clearance::CLEAR ? kNotTold : cycle.found.deciding.gradient);
  if (cycle.found.broken) text_->append(text, *cycle.found.broken);
  if (cycle.snapshot.beyond) {
    text += "; ";
    append(text, *robot_, *cycle.snapshot.beyond);
  }
  if (cycle.guaranteed) appendEnd(text, "; ", *cycle.guaranteed);
}

void ClearanceMessage::explainInvalid(const AssessedCycle& cycle) {
  if (message_.status.code != QueryStatus::OK) return;
  const bool nothing = robot_->candidates().empty() && cycle.state.objects()->pairCount() == 0;
  if (nothing)
    message_.status = statusOf(QueryStatus::NO_COLLISION_GEOMETRY, "the filter leaves no pair to check");
  else if (message_.pairs_unknown == 0 && cycle.bounds.code != QueryStatus::OK)
    message_.status = cycle.bounds;
  else if (cycle.frames.status.code != QueryStatus::OK)
    message_.status = cycle.frames.status;
  else
    message_.status = incompleteness(*robot_, cycle.found.counts, {});
}

}  // namespace proximity_server::node
