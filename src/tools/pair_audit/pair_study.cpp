#include "tools/pair_audit/pair_study.h"

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "system/pipeline.h"

#include <algorithm>
#include <numeric>
#include <random>

namespace proximity_server::tools {
namespace {

constexpr long kBlockSize = 64;     // states
constexpr int kBlocksInRound = 64;  // 4096 states, a small part of kQuietSamples
constexpr int kMaxSearchQueries = 2000;

/// The evidence of one block about each pair that it sampled.
using BlockEvidence = std::vector<PairEvidence>;

struct SampledBlock {
  long states = 0;
  std::mt19937_64 random;  ///< from which they are drawn
  BlockEvidence evidence;
};

/// Adds the distance of a pair in one state to the evidence. A pair counts as apart only if that is proven.
void add(const narrowphase::SignedDistance& distance, const scene::Positions& positions, PairEvidence& evidence) {
  const bool is_contact = !(distance.lower_bound > kContactDistance);
  if (is_contact && !evidence.contact) evidence.contact = positions;
  std::optional<scene::Positions>& first = distance.lower_bound > evidence.near ? evidence.apart : evidence.within;
  if (!first) first = positions;
  const double seen = is_contact ? 0.0 : distance.distance;
  if (seen < evidence.smallest) {
    evidence.smallest = seen;
    evidence.closest = positions;
  }
  if (seen > evidence.largest) {
    evidence.largest = seen;
    evidence.farthest = positions;
  }
}

/// Adds the evidence of a later block.
void add(const PairEvidence& later, PairEvidence& evidence) {
  evidence.samples += later.samples;
  if (!evidence.contact) evidence.contact = later.contact;
  if (!evidence.within) evidence.within = later.within;
  if (!evidence.apart) evidence.apart = later.apart;
  if (later.smallest < evidence.smallest) {
    evidence.smallest = later.smallest;
    evidence.closest = later.closest;
  }
  if (later.largest > evidence.largest) {
    evidence.largest = later.largest;
    evidence.farthest = later.farthest;
  }
}

bool isOpen(const PairEvidence& evidence) { return !evidence.contact || !evidence.apart; }

/// How many kinds of states were seen: in contact, near, not near.
int kindsSeen(const PairEvidence& evidence) {
  return evidence.contact.has_value() + evidence.within.has_value() + evidence.apart.has_value();
}

/// `evidence` is for pairs of which nothing was seen yet.
BlockEvidence sampleBlock(scene::Scene scene, scene::State state, const std::vector<scene::JointRange>& ranges,
                          BlockEvidence evidence, std::mt19937_64 random, long states, const TimeBudget& budget) {
  scene::Question question;
  question.depth = scene::Question::Depth::NotWanted;
  for (long i = 0; i < states && !budget.deadline.hasPassed(); ++i) {
    const scene::Positions positions = scene::randomPositions(scene.model().robot, ranges, random);
    state.set(scene::forwardKinematics(scene.model().robot, positions));
    for (PairEvidence& each : evidence) {
      // For a distance larger than the smallest so far a proof is enough, but where the largest is measured.
      question.threshold = std::max(each.smallest, each.largest > each.measured ? kContactDistance : each.measured);
      add(scene.proximity(state, each.pair, question).result, positions, each);
      ++each.samples;
    }
  }
  return evidence;
}

/// A search for contact, or for a distance beyond PairEvidence::measured.
class DistanceSearch {
 public:
  enum class Goal : unsigned char { Contact, Distance };

  DistanceSearch(Goal goal, scene::Scene& scene, scene::State& state, const std::vector<scene::JointRange>& ranges,
                 const TimeBudget& budget, PairEvidence& evidence)
      : goal_(goal),
        scene_(scene),
        state_(state),
        ranges_(ranges),
        budget_(budget),
        evidence_(evidence),
        positions_(goal == Goal::Contact ? evidence.closest : evidence.farthest),
        best_(valueAt(positions_)) {}

  /// Coordinate descent: steps of one joint at a time, halved when none of them helps.
  void run() {
    constexpr double kSmallestStep = 1e-3;  // a share of a range
    for (double step = 0.25; step > kSmallestStep && goesOn();) {
      bool helped = false;
      for (const scene::JointRange& range : ranges_) {
        for (const double side : {-1.0, 1.0}) helped = improves(range, side * step * range.width()) || helped;
      }
      if (!helped) step *= 0.5;
    }
  }

 private:
  bool goesOn() const {
    const bool found = goal_ == Goal::Contact ? evidence_.contact.has_value() : evidence_.largest > evidence_.measured;
    return !found && queries_ < kMaxSearchQueries && !budget_.deadline.hasPassed();
  }

  bool improves(const scene::JointRange& range, double step) {
    if (!goesOn()) return false;
    const double before = positions_[range.joint];
    positions_[range.joint] = range.typeable(before + step);
    if (positions_[range.joint] == before) return false;
    const bool is_allowed = !mostBroken(scene_.model().robot.inequalities, positions_);
    const double value = is_allowed ? valueAt(positions_) : best_;
    if (value < best_) {
      best_ = value;
      return true;
    }
    positions_[range.joint] = before;
    return false;
  }

  /// The value to minimise: the signed distance if contact is searched for, otherwise minus the signed distance.
  double valueAt(const scene::Positions& positions) {
    state_.set(scene::forwardKinematics(scene_.model().robot, positions));
    const narrowphase::SignedDistance answer = scene_.proximity(state_, evidence_.pair).result;
    ++queries_;
    add(answer, positions, evidence_);
    return goal_ == Goal::Contact ? answer.distance : -answer.distance;
  }

  const Goal goal_;
  scene::Scene& scene_;
  scene::State& state_;
  const std::vector<scene::JointRange>& ranges_;
  const TimeBudget& budget_;
  PairEvidence& evidence_;
  int queries_ = 0;
  scene::Positions positions_;
  double best_;
};

/// Searches for the kinds of states that were not seen.
PairEvidence searched(scene::Scene scene, scene::State state, const std::vector<scene::JointRange>& all_ranges,
                      const TimeBudget& budget, PairEvidence evidence) {
  using Goal = DistanceSearch::Goal;
  if (evidence.samples == 0) return evidence;
  const std::vector<scene::JointRange> ranges =
      scene::rangesBetween(scene.model().robot, all_ranges, evidence.pair.a.link(), evidence.pair.b.link());
  const bool always_near = evidence.largest <= evidence.measured;
  if (!evidence.contact) DistanceSearch(Goal::Contact, scene, state, ranges, budget, evidence).run();
  if (always_near) DistanceSearch(Goal::Distance, scene, state, ranges, budget, evidence).run();
  evidence.is_searched = !budget.deadline.hasPassed();
  return evidence;
}

double depthAt(scene::Scene& scene, scene::State& state, const scene::Positions& positions,
               const scene::ShapeRefPair& pair) {
  state.set(scene::forwardKinematics(scene.model().robot, positions));
  return std::max(0.0, -scene.proximity(state, pair).result.distance);
}

PairEvidence noEvidence(const scene::RobotModel& robot, const scene::LinkPair& pair, const StudyOptions& options) {
  PairEvidence evidence;
  evidence.pair = {{pair.link_a, 0}, {pair.link_b, 0}};
  evidence.are_neighbours = robot.areNeighbours(pair.link_a, pair.link_b);
  if (!evidence.are_neighbours) {
    evidence.near = std::max(options.distance, kContactDistance);
    evidence.measured = std::max(options.warn_distance, evidence.near);
  }
  const std::vector<int> joints =
      scene::jointsBetween(robot, robot.links[pair.link_a].body, robot.links[pair.link_b].body);
  evidence.has_known_ranges =
      std::all_of(joints.begin(), joints.end(), [&](int joint) { return scene::hasKnownRange(robot, joint); });
  return evidence;
}

/// A study in progress.
class Studying {
 public:
  Studying(const std::shared_ptr<const scene::SceneModel>& model, const StudyOptions& options,
           const StudyProgress& progress)
      : model_(model),
        options_(options),
        progress_(progress),
        scene_(model),
        state_(model),
        ranges_(scene::jointRanges(model->robot)) {
    study_.near = std::max(options.distance, kContactDistance);
    study_.measured = std::max(options.warn_distance, study_.near);
    for (const scene::LinkPair& pair : model->pairs.pairs) {
      if (pair.reason != scene::PairReason::SameBody) study_.pairs.push_back(noEvidence(model->robot, pair, options));
    }
  }

  void sample() {
    for (long quiet = 0; study_.end == SamplingEnd::MaxSamples && study_.samples < options_.most_samples;) {
      const long before = study_.samples;
      const bool changed = sampleRound();
      quiet = changed ? 0 : quiet + study_.samples - before;
      if (quiet >= kQuietSamples) study_.end = SamplingEnd::Quiet;
      if (options_.budget.deadline.hasPassed()) study_.end = SamplingEnd::OutOfTime;
      if (openPairs().empty()) study_.end = SamplingEnd::AllKnown;
    }
  }

  void search() {
    std::vector<PairEvidence> found;
    auto next = study_.pairs.begin();
    const auto read = [&](PairEvidence& evidence) {
      if (next == study_.pairs.end()) return false;
      evidence = *next++;
      return true;
    };
    const auto searchOne = [&](PairEvidence& evidence, int) {
      evidence = searched(scene_.forAnotherThread(), state_.forAnotherThread(), ranges_, options_.budget, evidence);
    };
    const auto keep = [&](const PairEvidence& evidence) {
      found.push_back(evidence);
      tell(StudyStage::Searching, static_cast<long>(found.size()), static_cast<long>(study_.pairs.size()));
    };
    system::runPipeline<PairEvidence>({read, searchOne, keep}, {options_.threads});
    study_.pairs = std::move(found);
  }

  /// Tries to prove of each pair the largest of the distances below which it was never seen.
  void prove() {
    const auto isNeverNear = [](const PairEvidence& evidence) { return !evidence.within && !evidence.are_neighbours; };
    proveBeyond(study_.measured, [&](const PairEvidence& evidence) {
      return isNeverNear(evidence) && evidence.smallest > evidence.measured;
    });
    proveBeyond(study_.near, [&](const PairEvidence& evidence) {
      return isNeverNear(evidence) && evidence.smallest <= evidence.measured;
    });
    proveBeyond(kContactDistance, [&](const PairEvidence& evidence) { return !isNeverNear(evidence); });
    study_.is_out_of_time = options_.budget.deadline.hasPassed();
  }

  void measureDepths() {
    scene::Scene scene = scene_.forAnotherThread();
    scene::State state = state_.forAnotherThread();
    for (PairEvidence& evidence : study_.pairs)
      if (evidence.contact) evidence.contact_depth = depthAt(scene, state, *evidence.contact, evidence.pair);
  }

  const PairStudy& study() const { return study_; }

 private:
  std::vector<std::size_t> openPairs() const {
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < study_.pairs.size(); ++i) {
      if (isOpen(study_.pairs[i])) open.push_back(i);
    }
    return open;
  }

  int kindsSeenOfAll() const {
    return std::accumulate(study_.pairs.begin(), study_.pairs.end(), 0,
                           [](int sum, const PairEvidence& evidence) { return sum + kindsSeen(evidence); });
  }

  /// Tries to prove that pairs without contact are farther apart than a distance [m]. States that refute it count as seen.
  template <typename IsWanted>
  void proveBeyond(double distance, const IsWanted& isWanted) {
    std::vector<scene::ShapeRefPair> pairs;
    std::vector<PairEvidence*> evidence;
    for (PairEvidence& each : study_.pairs) {
      if (each.contact || !each.has_known_ranges || !each.is_searched || !isWanted(each)) continue;
      pairs.push_back(each.pair);
      evidence.push_back(&each);
    }
    scene::ProofQuestion question;
    question.contact_distance = distance;
    question.most_boxes = options_.most_boxes;
    question.tightness = 0.5;
    question.threads = options_.threads;
    question.deadline = options_.budget.deadline;
    question.progress = [&](double done) { tell(StudyStage::Proving, done); };
    const std::vector<scene::PairProof> proofs = scene::proveApart(model_, pairs, ranges_, question);
    scene::Scene scene = scene_.forAnotherThread();
    scene::State state = state_.forAnotherThread();
    for (std::size_t i = 0; i < proofs.size(); ++i) {
      if (proofs[i].lower_bound > std::max(kContactDistance, evidence[i]->proven.value_or(0.0)))
        evidence[i]->proven = proofs[i].lower_bound;
      if (proofs[i].outcome != scene::ProofOutcome::Refuted) continue;
      const auto between = scene::rangesBetween(model_->robot, ranges_, pairs[i].a.link(), pairs[i].b.link());
      // A proof is about all of the ranges, also about what the inequalities leave out.
      if (mostBroken(scene::inequalitiesOver(between, model_->robot), proofs[i].closest)) continue;
      state.set(scene::forwardKinematics(model_->robot, proofs[i].closest));
      add(scene.proximity(state, pairs[i]).result, proofs[i].closest, *evidence[i]);
    }
  }

  /// Returns the evidence of these pairs without what was seen of them.
  BlockEvidence unseen(const std::vector<std::size_t>& indices) const {
    BlockEvidence fresh(indices.size());
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const PairEvidence& known = study_.pairs[indices[i]];
      fresh[i].pair = known.pair;
      fresh[i].near = known.near;
      fresh[i].measured = known.measured;
    }
    return fresh;
  }

  /// Draws one round of states. Returns whether the class of a pair changed.
  bool sampleRound() {
    const std::vector<std::size_t> open = openPairs();
    const BlockEvidence fresh = unseen(open);
    const int kinds_before = kindsSeenOfAll();

    int blocks = 0;
    long drawn = study_.samples;
    const auto draw = [&](SampledBlock& block) {
      if (blocks == kBlocksInRound || drawn >= options_.most_samples) return false;
      ++blocks;
      block.states = std::min(kBlockSize, options_.most_samples - drawn);
      std::seed_seq seed{options_.seed, static_cast<unsigned long>(drawn / kBlockSize)};
      block.random.seed(seed);
      drawn += block.states;
      return true;
    };
    const auto sample = [&](SampledBlock& block, int) {
      block.evidence = sampleBlock(scene_.forAnotherThread(), state_.forAnotherThread(), ranges_, fresh, block.random,
                                   block.states, options_.budget);
      if (!fresh.empty()) block.states = block.evidence.front().samples;  // fewer if the time was over
    };
    const auto addBlock = [&](const SampledBlock& block) {
      study_.samples += block.states;
      for (std::size_t i = 0; i < open.size(); ++i) add(block.evidence[i], study_.pairs[open[i]]);
      tell(StudyStage::Sampling, study_.samples, options_.most_samples);
    };
    system::runPipeline<SampledBlock>({draw, sample, addBlock}, {options_.threads});
    return kindsSeenOfAll() > kinds_before;
  }

  void tell(StudyStage stage, double done) const {
    if (progress_) progress_(stage, done);
  }
  void tell(StudyStage stage, long done, long all) const {
    tell(stage, static_cast<double>(done) / static_cast<double>(all));
  }

  const std::shared_ptr<const scene::SceneModel> model_;
  const StudyOptions options_;
  const StudyProgress& progress_;
  const scene::Scene scene_;  ///< each thread has another scene and state made from these
  const scene::State state_;
  const std::vector<scene::JointRange> ranges_;
  PairStudy study_;
};

}  // namespace

NearClass PairEvidence::nearClass() const {
  if (within && apart) return NearClass::Sometimes;
  if (!has_known_ranges || !is_searched) return NearClass::Undecided;
  return within ? NearClass::Always : NearClass::Never;
}

bool PairEvidence::isBeyond() const { return nearClass() == NearClass::Never && smallest > measured; }

bool PairEvidence::isProvenBeyond() const { return isBeyond() && proven && *proven > measured; }

bool PairEvidence::canCollide() const { return contact && largest > kContactDistance; }

bool PairEvidence::alwaysInContact() const {
  return has_known_ranges && is_searched && contact && largest <= kContactDistance;
}

PairStudy studyPairs(const std::shared_ptr<const scene::SceneModel>& model, const StudyOptions& options,
                     const StudyProgress& progress) {
  Studying studying(model, options, progress);
  studying.sample();
  studying.search();
  studying.prove();
  studying.measureDepths();
  return studying.study();
}

const PairEvidence& evidenceOf(const scene::ShapeRefPair& pair, const PairStudy& study) {
  return *std::find_if(study.pairs.begin(), study.pairs.end(), [&](const PairEvidence& evidence) {
    return evidence.pair.a.link() == pair.a.link() && evidence.pair.b.link() == pair.b.link();
  });
}

std::vector<scene::AlwaysNear> alwaysNear(const PairStudy& study, const scene::PairTable& pairs) {
  std::vector<scene::AlwaysNear> near;
  for (const PairEvidence& evidence : study.pairs) {
    const scene::LinkPair& pair = pairs.pairs[pairs.find(evidence.pair.a.link(), evidence.pair.b.link())];
    const bool is_always_near =
        evidence.has_known_ranges && evidence.is_searched && evidence.largest <= evidence.measured;
    if (pair.reason != scene::PairReason::Checked || evidence.are_neighbours) continue;
    if (is_always_near && !evidence.alwaysInContact())
      near.push_back({evidence.pair, evidence.smallest, evidence.largest});
  }
  return near;
}

}  // namespace proximity_server::tools
