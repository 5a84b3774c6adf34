#include "tools/clearance/clearance_assertion.h"

#include "proximity_server/scene/motion/frames_on_links.h"
#include "tools/robot/robot_text.h"
#include "tools/text/csv.h"

#include <cmath>
#include <vector>

namespace proximity_server::tools {
namespace {

/// The most characters of the joint positions in a message: enough for about ten joints.
constexpr std::size_t kLongestJoints = 300;

std::string metres(double length) { return shortest(length) + " m"; }

std::string placeIn(const TrajectorySegment& segment, double fraction) {
  return " (" + shortest(segment.begin) + " to " + shortest(segment.end) + " s)" +
         (std::isfinite(fraction) ? ", at " + shortest(segment.timeAt(fraction)) + " s" : "");
}

/// "a", "a and b", "a, b and c"
std::string enumeration(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    text += (i == 0 ? "" : i + 1 < items.size() ? ", " : " and ") + items[i];
  }
  return text;
}

}  // namespace

void ClearanceAssertion::add(const StateClearance& answer) {
  const SmallestDistance& smallest = answer.smallest;
  Row row;
  row.number = answer.state;
  const scene::ShapeRefPair& pair = smallest.pair.asked;
  row.unknown_pairs = smallest.unknown_pairs;
  if (isNamed(pair)) {
    row.distance = smallest.pair.result.distance;
    row.lower_bound = smallest.lower_bound;
    row.upper_bound = smallest.pair.result.upper_bound;
    row.status = smallest.pair.result.status;
  }
  addRow(row, pair, answer.objects.get(), answer.positions);
}

void ClearanceAssertion::add(const SegmentClearance& answer) {
  const scene::RobotMinimum& minimum = answer.minimum;
  Row row;
  row.number = answer.segment.number;
  row.place = placeIn(answer.segment, minimum.time);
  row.distance = minimum.pair.result.distance;
  row.lower_bound = minimum.lower_bound;
  row.upper_bound = minimum.upper_bound;
  row.status = minimum.status;
  row.unknown_pairs = minimum.counts.unknown;
  addRow(row, minimum.pair.asked, answer.segment.objects.get(), minimum.state);
}

void ClearanceAssertion::addRow(Row row, const scene::ShapeRefPair& pair, const scene::Objects* objects,
                                const scene::Positions& positions) {
  ++rows_;
  row.verdict = verdictOf(row);
  ++counts_[row.verdict];
  const bool is_proven = row.verdict == Verdict::Proven;
  const bool is_closest = !closest_ || row.lower_bound < closest_->lower_bound;
  const bool is_first = !is_proven && !first_;
  const bool is_worst = !is_proven && (!worst_ || row.upper_bound < worst_->upper_bound);
  if ((is_closest || is_first || is_worst) && isNamed(pair)) {
    row.pair = nameOf(pair.a, robot_, objects) + " - " + nameOf(pair.b, robot_, objects);
    row.joints = joints(pair, objects, positions);
  }
  if (is_closest) closest_ = row;
  if (is_first) first_ = row;
  if (is_worst) worst_ = row;
}

ClearanceAssertion::Verdict ClearanceAssertion::verdictOf(const Row& row) const {
  if (row.upper_bound <= distance_) return Verdict::TooClose;
  if (row.unknown_pairs > 0 || row.status == narrowphase::Status::Unknown) return Verdict::Unknown;
  if (row.lower_bound > distance_) return Verdict::Proven;
  if (lower_bounds_ == LowerBounds::Guaranteed) return Verdict::Uncertain;
  return row.status == narrowphase::Status::Converged ? Verdict::Enclosed : Verdict::Undecided;
}

/// The positions of the joints that move the two of the pair relative to each other.
std::string ClearanceAssertion::joints(const scene::ShapeRefPair& pair, const scene::Objects* objects,
                                       const scene::Positions& positions) const {
  const auto link = [&](const scene::ShapeRef& ref) {
    return ref.isLink() ? ref.link() : carryingLink(robot_, *objects->object(ref.object()));
  };
  const std::string text = stateText(robot_, {{link(pair.a)}, {link(pair.b)}}, positions);
  return text.size() > kLongestJoints ? "" : text;
}

std::string ClearanceAssertion::describe(const Row& row) const {
  std::string text = (kind_ == RowKind::State ? "state " : "segment ") + std::to_string(row.number) + row.place + ": ";
  if (!row.pair.empty()) {
    text += row.pair + " at " + metres(row.distance) +
            (lower_bounds_ == LowerBounds::Guaranteed
                 ? ", guaranteed " + metres(row.lower_bound)
                 : ", bounds " + metres(row.lower_bound) + " and " + metres(row.upper_bound));
    if (!row.joints.empty()) text += ", with " + row.joints;
    if (row.verdict == Verdict::Undecided) text += "; the budget of the search ended there";
    if (row.verdict == Verdict::Unknown) text += "; ";
  }
  if (row.verdict == Verdict::Unknown)
    text += row.unknown_pairs > 0 ? "nothing is known of " + std::to_string(row.unknown_pairs) + " pairs"
                                  : "the motion is too large to compute with";
  return text;
}

std::string ClearanceAssertion::countText(long count) const {
  return std::to_string(count) + (kind_ == RowKind::State ? " state" : " segment") + (count == 1 ? "" : "s");
}

const char* ClearanceAssertion::toString(Verdict verdict) {
  switch (verdict) {
    case Verdict::Proven:
      return "proven";
    case Verdict::TooClose:
      return "at that distance or below";
    case Verdict::Enclosed:
      return "so close to it that the bounds lie on either side";
    case Verdict::Uncertain:
      return "within the uncertainty of that distance";
    case Verdict::Undecided:
      return "not decided within the budget of the search";
    case Verdict::Unknown:
      break;
  }
  return "with pairs of which nothing is known";
}

std::string ClearanceAssertion::causes() const {
  std::vector<std::string> causes;
  for (const auto& [verdict, count] : counts_)
    if (verdict != Verdict::Proven) causes.push_back(std::to_string(count) + " " + toString(verdict));
  return enumeration(causes);
}

std::string ClearanceAssertion::report() const {
  const std::string above = "above " + metres(distance_);
  if (!first_) {
    return "proven: in " + countText(rows_) + " " + pairs_ + " are " + above + "; the closest is " +
           describe(*closest_);
  }
  const long proven = counts_.count(Verdict::Proven) > 0 ? counts_.at(Verdict::Proven) : 0;
  return "not proven to be " + above + ": " + std::to_string(rows_ - proven) + " of " + countText(rows_) + " (" +
         causes() + ")\n  first: " + describe(*first_) +
         "\n  worst: " + (worst_->number == first_->number ? "the same" : describe(*worst_));
}

}  // namespace proximity_server::tools
