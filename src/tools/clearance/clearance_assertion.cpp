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

/// "a", "a and b", "a, b and c"
std::string enumeration(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    text += (i == 0 ? "" : i + 1 < items.size() ? ", " : " and ") + items[i];
  }
  return text;
}

}  // namespace

void ClearanceAssertion::add(const ClearanceAnswer& answer) {
  const narrowphase::SignedDistance& bounds = answer.closest.pair.result;
  const auto keep = [&](std::optional<ClearanceAnswer>& kept) {  // without lists, which may be long
    kept = {answer.number, answer.begin, answer.end, answer.objects, answer.closest, answer.unknown_pairs};
  };
  const Verdict verdict = verdictOf(answer);
  ++rows_;
  ++counts_[verdict];
  if (!closest_ || bounds.lower_bound < closest_->closest.pair.result.lower_bound) keep(closest_);
  if (verdict == Verdict::Proven) return;
  if (!first_) keep(first_);
  if (!worst_ || bounds.upper_bound < worst_->closest.pair.result.upper_bound) keep(worst_);
}

ClearanceAssertion::Verdict ClearanceAssertion::verdictOf(const ClearanceAnswer& answer) const {
  const narrowphase::SignedDistance& bounds = answer.closest.pair.result;
  const narrowphase::Status status = answer.closest.status;
  if (bounds.upper_bound <= distance_) return Verdict::TooClose;
  if (answer.unknown_pairs > 0 || status == narrowphase::Status::Unknown) return Verdict::Unknown;
  if (bounds.lower_bound > distance_) return Verdict::Proven;
  if (lower_bounds_ == LowerBounds::Guaranteed) return Verdict::Uncertain;
  return status == narrowphase::Status::Converged ? Verdict::Enclosed : Verdict::Undecided;
}

/// The positions of the joints that move the two of the closest pair relative to each other; "" if that is a long text.
std::string ClearanceAssertion::joints(const ClearanceAnswer& answer) const {
  const auto link = [&](const scene::ShapeRef& ref) {
    if (ref.isPoint()) return 0;  // the root link, in whose frame points are
    return ref.isLink() ? ref.link() : carryingLink(robot_, *answer.objects->object(ref.object()));
  };
  const scene::ShapeRefPair& pair = answer.closest.pair.asked;
  const std::string text = stateText(robot_, {{link(pair.a)}, {link(pair.b)}}, answer.closest.positions);
  return text.size() > kLongestJoints ? "" : text;
}

std::string ClearanceAssertion::describe(const ClearanceAnswer& answer) const {
  const auto& [pair, status, time, positions] = answer.closest;
  const Verdict verdict = verdictOf(answer);
  std::string text = (kind_ == RowKind::State ? "state " : "segment ") + std::to_string(answer.number);
  if (kind_ == RowKind::Segment) {
    text += " (" + shortest(answer.begin) + " to " + shortest(answer.end) + " s)";
    if (std::isfinite(time)) text += ", at " + shortest(time) + " s";
  }
  text += ": ";
  if (isNamed(pair.asked)) {
    text += nameOf(pair.asked.a, robot_, answer.objects.get()) + " - " +
            (pair.asked.b.isPoint() ? "point " + std::to_string(pair.asked.b.point())
                                    : nameOf(pair.asked.b, robot_, answer.objects.get())) +
            " at " + metres(pair.result.distance) +
            (lower_bounds_ == LowerBounds::Guaranteed
                 ? ", guaranteed " + metres(pair.result.lower_bound)
                 : ", bounds " + metres(pair.result.lower_bound) + " and " + metres(pair.result.upper_bound));
    if (const std::string moving = joints(answer); !moving.empty()) text += ", with " + moving;
    if (verdict == Verdict::Undecided) text += "; the budget of the search ended there";
    if (verdict == Verdict::Unknown) text += "; ";
  }
  if (verdict == Verdict::Unknown)
    text += answer.unknown_pairs > 0 ? "nothing is known of " + std::to_string(answer.unknown_pairs) + " pairs"
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
