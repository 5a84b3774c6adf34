#include "tools/pair_audit/safe_limits.h"

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "proximity_server/scene/query/scene.h"
#include "tools/pair_audit/box_growth.h"
#include "tools/pair_audit/range_search.h"
#include "tools/robot/robot_text.h"
#include "tools/text/csv.h"

#include <algorithm>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

constexpr int kStates = 2000;  // random states from which the search may begin
constexpr int kStarts = 4;     // the number of states about which a box grows
constexpr double kLeastKept = 0.3;

/// Proves pairs apart in boxes that grow, and asks nothing twice.
class GrowingProof {
 public:
  GrowingProof(std::shared_ptr<const scene::SceneModel> model, const RangeOptions& options)
      : model_(std::move(model)), budget_(options.budget), question_(options.question()) {}

  /// Returns whether two neighbours are proven not to be in contact.
  bool areApart(const scene::ShapeRefPair& neighbours, const scene::JointBox& box) const {
    scene::ProofQuestion question = question_;
    question.contact_distance = kContactDistance;
    return proof(neighbours, box, question).outcome == scene::ProofOutcome::Proven;
  }

  void use(const std::vector<scene::ShapeRefPair>& pairs) {
    pairs_.clear();
    for (const scene::ShapeRefPair& pair : pairs) pairs_.push_back({pair, {}});
  }

  /// True if all pairs are proven. The pair that fails is the first one that is tried the next time.
  bool areProven(const scene::JointBox& box) {
    for (auto tried = pairs_.begin(); tried != pairs_.end(); ++tried) {
      if (!tried->proven.empty() && contains(tried->proven, partOf(box, tried->proven))) continue;
      const scene::PairProof found = proof(tried->pair, box, question_);
      if (found.outcome != scene::ProofOutcome::Proven) {
        std::rotate(pairs_.begin(), tried, tried + 1);
        return false;
      }
      tried->proven = found.box;
    }
    return true;
  }

 private:
  struct Tried {
    scene::ShapeRefPair pair;
    scene::JointBox proven;  ///< a box of its joints in which it is proven; empty: none yet
  };

  scene::PairProof proof(const scene::ShapeRefPair& pair, const scene::JointBox& box,
                         const scene::ProofQuestion& question) const {
    const scene::PairProof found = scene::proveApart(model_, {pair}, box, question).front();
    budget_.require();
    return found;
  }

  /// The intervals of the joints of another box.
  static scene::JointBox partOf(const scene::JointBox& box, const scene::JointBox& joints) {
    scene::JointBox part;
    for (const scene::JointRange& interval : joints) part.push_back(*scene::intervalOf(box, interval.joint));
    return part;
  }

  const std::shared_ptr<const scene::SceneModel> model_;
  const TimeBudget& budget_;
  scene::ProofQuestion question_;
  std::vector<Tried> pairs_;
};

class SafeLimitSearch {
 public:
  SafeLimitSearch(const std::shared_ptr<const scene::SceneModel>& model, const PairStudy& study,
                  const RangeOptions& options)
      : model_(model), study_(study), options_(options), proof_(model, options) {
    safe_.limits = scene::knownRanges(model->robot);
    outer_ = safe_.limits;
  }

  SafeLimits run() {
    for (const PairEvidence& evidence : study_.pairs) cover(evidence);
    within_ = outer_;
    for (const PairEvidence* evidence : open_) tightenWithin(*evidence);
    std::vector<scene::ShapeRefPair> open;
    for (const PairEvidence* evidence : open_) open.push_back(evidence->pair);
    proof_.use(open);
    std::optional<scene::JointBox> best;
    const std::vector<scene::Positions> starts = startStates(open);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const std::optional<scene::JointBox> box = grownFrom(starts[i]);
      if (box && (!best || shareOf(*box, outer_) > shareOf(*best, outer_))) best = box;
      if (options_.progress) options_.progress(static_cast<double>(i + 1) / static_cast<double>(starts.size()));
    }
    if (best && isProvenAsAWhole(*best)) safe_.box = best;
    return safe_;
  }

 private:
  void cover(const PairEvidence& evidence) {
    const int found = model_->pairs.find(evidence.pair.a.link(), evidence.pair.b.link());
    const scene::PairReason reason = model_->pairs.pairs[found].reason;
    const auto leaveOut = [&](const std::string& why) { safe_.uncovered.push_back({evidence.pair, why}); };
    if (!evidence.has_known_ranges) return leaveOut("a joint between them has no known limits");
    if (evidence.alwaysInContact()) return leaveOut("always in contact");
    if (!evidence.are_neighbours && evidence.largest <= options_.distance)
      return leaveOut("always within " + shortest(options_.distance) + " m");
    if (!evidence.proven || (!evidence.are_neighbours && *evidence.proven <= options_.distance)) {
      if (evidence.are_neighbours && !tighten(evidence)) return leaveOut("neighbours, not proven apart");
      if (!evidence.are_neighbours && reason != scene::PairReason::Checked) return leaveOut(toString(reason));
      if (!evidence.are_neighbours) open_.push_back(&evidence);
    }
    (evidence.are_neighbours ? neighbours_ : others_).push_back(evidence.pair);
    safe_.covered.push_back(evidence.pair);
  }

  /// Tightens the joint of neighbours so that they are proven apart.
  bool tighten(const PairEvidence& evidence) {
    const std::vector<scene::JointRange> between =
        scene::rangesBetween(model_->robot, outer_, evidence.pair.a.link(), evidence.pair.b.link());
    if (between.size() != 1) return false;
    const auto joint = std::find_if(outer_.begin(), outer_.end(),
                                    [&](const scene::JointRange& range) { return range.joint == between[0].joint; });
    const auto at = static_cast<std::size_t>(joint - outer_.begin());
    const scene::JointRange range = outer_[at];
    const auto proves = [&](const scene::JointBox& box) { return proof_.areApart(evidence.pair, box); };
    scene::JointBox box = outer_;
    box[at].lower = box[at].upper = std::clamp(evidence.farthest.at(range.joint), range.lower, range.upper);
    if (!proves(box)) return false;
    extend(box, at, End::Lower, range, proves);
    extend(box, at, End::Upper, range, proves);
    if (box[at].width() < kLeastShare * range.width()) return false;
    outer_ = box;
    return true;
  }

  /// Tightens the joint of a pair that is apart in a large range of it.
  void tightenWithin(const PairEvidence& evidence) {
    const scene::JointRange* best = nullptr;
    const PairRanges found = provenRanges(model_, evidence, within_, options_);
    for (const scene::JointBox& range : found.ranges) {
      if (range.empty()) return;  // apart in all of within_
      if (!best || shareOf(range, within_) > shareOf({*best}, within_)) best = &range[0];
    }
    if (!best || shareOf({*best}, within_) < kLeastKept) return;
    for (scene::JointRange& interval : within_)
      if (interval.joint == best->joint) interval = *best;
  }

  /// The states with the largest smallest distance of an open pair, the best first; fewer if fewer are apart.
  std::vector<scene::Positions> startStates(const std::vector<scene::ShapeRefPair>& open) const {
    scene::Scene scene(model_);
    scene::State posed(model_);
    std::mt19937_64 random(options_.seed);
    std::vector<std::pair<double, scene::Positions>> states;
    scene::Positions middle(model_->robot.joints.size(), 0.0), zero = middle;
    for (const scene::JointRange& range : within_) {
      middle[range.joint] = range.typeable(0.5 * (range.lower + range.upper));
      zero[range.joint] = std::clamp(0.0, range.lower, range.upper);
    }
    for (int i = 0; i < kStates; ++i) {
      options_.budget.require();
      scene::Positions state =
          i == 0 ? middle : (i == 1 ? zero : scene::randomPositions(model_->robot, within_, random));
      posed.set(scene::forwardKinematics(model_->robot, state));
      const scene::PairProximity* closest = scene.minimum(posed, open);
      const double smallest = closest ? closest->result.lower_bound : std::numeric_limits<double>::infinity();
      if (smallest > options_.distance + kContactDistance) states.emplace_back(smallest, std::move(state));
    }
    const auto isBetter = [](const auto& one, const auto& other) { return one.first > other.first; };
    std::stable_sort(states.begin(), states.end(), isBetter);
    std::vector<scene::Positions> best;
    for (std::size_t i = 0; i < states.size() && i < kStarts; ++i) best.push_back(states[i].second);
    return best;
  }

  /// The part of the limits that reaches from a state by a share of their widths.
  scene::JointBox about(const scene::Positions& state, double share) const {
    scene::JointBox box = within_;
    for (scene::JointRange& interval : box) {
      const scene::JointRange limits = interval;
      const double position = state[limits.joint], radius = share * limits.width();
      interval.lower = std::max(limits.lower, limits.typeable(position - radius));
      interval.upper = std::min(limits.upper, limits.typeable(position + radius));
    }
    return box;
  }

  std::optional<scene::JointBox> grownFrom(const scene::Positions& state) {
    const auto areProven = [&](const scene::JointBox& box) { return proof_.areProven(box); };
    double proven = 0.0, open = 1.0;
    scene::JointBox box = about(state, 0.0);
    if (!areProven(box)) return std::nullopt;
    if (areProven(within_)) {
      box = within_;
      proven = 1.0;
    }
    while (open - proven > 1.0 / 64.0) {
      const double share = 0.5 * (proven + open);
      const scene::JointBox larger = about(state, share);
      (areProven(larger) ? proven : open) = share;
      if (proven == share) box = larger;
    }
    for (std::size_t at = 0; at < box.size(); ++at)
      for (const End end : {End::Lower, End::Upper}) extend(box, at, end, outer_[at], areProven);
    return box;
  }

  bool isProvenAsAWhole(const scene::JointBox& box) const {
    return areProven(neighbours_, 0.0, box) && areProven(others_, options_.distance, box);
  }
  bool areProven(const std::vector<scene::ShapeRefPair>& pairs, double distance, const scene::JointBox& box) const {
    scene::ProofQuestion question;
    question.contact_distance = distance + kContactDistance;
    question.most_boxes = 10 * options_.most_boxes;
    question.threads = options_.threads;
    question.deadline = options_.budget.deadline;
    const std::vector<scene::PairProof> proofs = scene::proveApart(model_, pairs, box, question);
    options_.budget.require();
    return std::all_of(proofs.begin(), proofs.end(),
                       [](const scene::PairProof& proof) { return proof.outcome == scene::ProofOutcome::Proven; });
  }

  const std::shared_ptr<const scene::SceneModel> model_;
  const PairStudy& study_;
  const RangeOptions& options_;
  GrowingProof proof_;
  scene::JointBox outer_;                  ///< the limits, tightened for neighbours
  scene::JointBox within_;                 ///< outer_, tightened for pairs that are apart in a range of one joint
  std::vector<const PairEvidence*> open_;  ///< the covered pairs that are not proven in all of outer_
  std::vector<scene::ShapeRefPair> neighbours_, others_;  ///< the covered pairs
  SafeLimits safe_;
};

std::string intervalText(const scene::JointRange& interval) {
  return "from " + shortest(interval.lower) + " to " + shortest(interval.upper);
}

}  // namespace

SafeLimits safeLimits(const std::shared_ptr<const scene::SceneModel>& model, const PairStudy& study,
                      const RangeOptions& options) {
  return SafeLimitSearch(model, study, options).run();
}

std::string safeLimitsText(const scene::RobotModel& robot, const SafeLimits& safe) {
  std::string text = "\nSafe limits: ";
  if (safe.box) {
    text += std::to_string(safe.covered.size()) + " pairs are proven apart within them\n";
    for (const scene::JointRange& interval : *safe.box)
      text += "  " + robot.joints[interval.joint].name + " " + intervalText(interval) + ", of " +
              intervalText(*scene::intervalOf(safe.limits, interval.joint)) + "\n";
  } else {
    text += "none were proven\n";
  }
  text += "They say nothing about these pairs (" + std::to_string(safe.uncovered.size()) + ")\n";
  for (const SafeLimits::Uncovered& left : safe.uncovered)
    text += "  " + nameOf(left.pair.a, robot) + " - " + nameOf(left.pair.b, robot) + ": " + left.reason + "\n";
  return text;
}

std::string safeLimitsYaml(const scene::RobotModel& robot, const SafeLimits& safe) {
  if (!safe.box) throw std::invalid_argument("no safe limits were proven, so there is nothing to write");
  std::string text = "# Limits within which " + std::to_string(safe.covered.size()) +
                     " pairs of links are proven apart, for prove --box; behind them those of the URDF.\n";
  for (const scene::JointRange& interval : *safe.box)
    text += scene::yamlName(robot.joints[interval.joint].name) + ": [" + shortest(interval.lower) + ", " +
            shortest(interval.upper) + "]  # " + intervalText(*scene::intervalOf(safe.limits, interval.joint)) + "\n";
  return text;
}

}  // namespace proximity_server::tools
