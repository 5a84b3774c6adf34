#include "tools/pair_audit/range_search.h"

#include "proximity_server/scene/proof/prove_apart.h"
#include "system/pipeline.h"
#include "tools/pair_audit/box_growth.h"
#include "tools/text/csv.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <utility>

namespace proximity_server::tools {
namespace {

/// The search of one pair.
class RangeSearch {
 public:
  RangeSearch(std::shared_ptr<const scene::SceneModel> model, const PairEvidence& evidence, const RangeOptions& options)
      : model_(std::move(model)), evidence_(evidence), budget_(options.budget), question_(options.question()) {}

  PairRanges run(const scene::JointBox& limits) {
    if (proves(limits)) return {evidence_.pair, bound_, {{}}};
    for (const int joint : leadersBetween()) limits_.push_back(*scene::intervalOf(limits, joint));
    for (std::size_t at = 0; at < limits_.size(); ++at) {
      const std::vector<scene::JointRange> ranges = rangesOf(at);
      if (ranges.size() == 1 && shareOf({ranges[0]}, limits_) == 1.0) return {evidence_.pair, bound_, {{}}};
      for (const scene::JointRange& range : ranges)
        if (shareOf({range}, limits_) >= kLeastShare) found_.push_back({range});
    }
    return {evidence_.pair, bound_, found_};
  }

 private:
  /// The ranges of one joint, in their order, without overlap.
  std::vector<scene::JointRange> rangesOf(std::size_t at) {
    const scene::JointRange& limits = limits_[at];
    std::vector<scene::JointRange> ranges;
    for (const double start :
         {limits.lower, std::clamp(evidence_.farthest.at(limits.joint), limits.lower, limits.upper), limits.upper}) {
      if (!ranges.empty() && start <= ranges.back().upper) continue;
      const std::optional<scene::JointRange> range = rangeAbout(at, start);
      if (!range) continue;
      if (!ranges.empty() && range->lower <= ranges.back().upper)
        ranges.back().upper = range->upper;
      else
        ranges.push_back(*range);
    }
    return ranges;
  }

  std::optional<scene::JointRange> rangeAbout(std::size_t at, double start) {
    const auto isProven = [&](const scene::JointBox& larger) { return proves(larger); };
    scene::JointBox box = limits_;
    box[at].lower = box[at].upper = start;
    if (!proves(box)) return std::nullopt;
    for (const End end : {End::Lower, End::Upper}) extend(box, at, end, limits_[at], isProven);
    return box[at];
  }

  /// The joints that move the pair, without followers.
  std::set<int> leadersBetween() const {
    const scene::RobotModel& robot = model_->robot;
    const auto bodyOf = [&](const scene::ShapeRef& ref) { return robot.links[ref.link()].body; };
    std::set<int> leaders;
    for (const int joint : scene::jointsBetween(robot, bodyOf(evidence_.pair.a), bodyOf(evidence_.pair.b)))
      leaders.insert(robot.leaderOf(joint).joint);
    return leaders;
  }

  bool proves(const scene::JointBox& box) {
    const scene::PairProof found = scene::proveApart(model_, {evidence_.pair}, box, question_).front();
    budget_.require();
    if (found.outcome != scene::ProofOutcome::Proven) return false;
    bound_ = std::min(bound_, found.lower_bound);
    return true;
  }

  const std::shared_ptr<const scene::SceneModel> model_;
  const PairEvidence& evidence_;
  const TimeBudget& budget_;
  scene::ProofQuestion question_;
  scene::JointBox limits_;  ///< of the joints between the two
  std::vector<scene::JointBox> found_;
  double bound_ = std::numeric_limits<double>::infinity();  ///< [m] the smallest that was proven
};

}  // namespace

PairRanges provenRanges(const std::shared_ptr<const scene::SceneModel>& model, const PairEvidence& evidence,
                        const scene::JointBox& limits, const RangeOptions& options) {
  return RangeSearch(model, evidence, options).run(limits);
}

std::vector<PairRanges> provenRanges(const std::shared_ptr<const scene::SceneModel>& model, const PairStudy& study,
                                     const RangeOptions& options) {
  std::vector<const PairEvidence*> pairs;
  for (const PairEvidence& evidence : study.pairs) {
    const int pair = model->pairs.find(evidence.pair.a.link(), evidence.pair.b.link());
    const bool is_checked = model->pairs.pairs[pair].reason == scene::PairReason::Checked;
    if (is_checked && evidence.has_known_ranges && evidence.largest > options.distance) pairs.push_back(&evidence);
  }
  struct Search {
    const PairEvidence* evidence = nullptr;
    PairRanges found{};
  };
  const scene::JointBox limits = scene::knownRanges(model->robot);
  std::vector<PairRanges> proven;
  std::size_t next = 0, done = 0;
  const auto read = [&](Search& search) {
    if (next == pairs.size()) return false;
    search.evidence = pairs[next++];
    return true;
  };
  const auto work = [&](Search& search, int) { search.found = provenRanges(model, *search.evidence, limits, options); };
  const auto keep = [&](const Search& search) {
    if (!search.found.ranges.empty()) proven.push_back(search.found);
    if (options.progress) options.progress(static_cast<double>(++done) / static_cast<double>(pairs.size()));
  };
  system::runPipeline<Search>({read, work, keep}, {options.threads});
  return proven;
}

std::string rangesText(const scene::RobotModel& robot, const std::vector<PairRanges>& pairs) {
  std::string text =
      "\nProven apart in a range of one joint, or in all states (" + std::to_string(pairs.size()) + ")\n";
  for (const PairRanges& proven : pairs) {
    std::string ranges;
    for (const scene::JointBox& range : proven.ranges)
      for (const scene::JointRange& interval : range)
        ranges += ", " + robot.joints[interval.joint].name + " from " + shortest(interval.lower) + " to " +
                  shortest(interval.upper);
    text += "  " + nameOf(proven.pair.a, robot) + " - " + nameOf(proven.pair.b, robot) + ": at least " +
            shortest(proven.distance) + " m" + (ranges.empty() ? ", always" : ranges) + "\n";
  }
  return text;
}

}  // namespace proximity_server::tools
