#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "proximity_server/scene/model/joint_ranges.h"
#include "tools/pair_audit/separation_proof.h"

namespace proximity_server::tools {

/// What two links do over all states that were seen.
enum class ContactClass : unsigned char {
  Always,
  Never,
  Sometimes,
  Undecided  ///< always or never so far, but a joint between the two can do more than was tried
};

/// What is known about the contact of two links that are not one body.
struct PairEvidence {
  scene::ShapeRefPair pair;
  bool are_neighbours = false;   ///< see RobotModel::areNeighbours
  bool has_known_ranges = true;  ///< those of all joints between the two, see scene::hasKnownRange()
  long samples = 0;              ///< random states, until both kinds had been seen
  double smallest = std::numeric_limits<double>::infinity();  ///< [m] distance seen; 0: contact
  scene::Positions closest;                                   ///< where that was
  std::optional<scene::Positions> contact, apart;             ///< the first state of either kind
  double contact_depth = 0.0;                                 ///< [m] penetration depth in the state `contact`
  std::optional<double> proven;                               ///< [m] proven lower bound of the distance; above 0

  ContactClass contactClass() const;
};

struct StudyOptions {
  long most_samples = 100000;
  unsigned long seed = 1;
  int threads = 1;
};

/// Share of the states that a class may have without having been seen, see studyPairs().
constexpr double kUnseenShare = 1e-4;
constexpr long kQuietSamples = 30000;  ///< 3 / kUnseenShare

/// Why no more random states were drawn.
enum class SamplingEnd : unsigned char {
  MostSamples,  ///< the number asked for was reached
  Quiet,        ///< no pair changed its class in the last kQuietSamples
  AllKnown      ///< every pair was seen both in contact and apart
};

struct PairStudy {
  std::vector<PairEvidence> pairs;  ///< all pairs of links with geometry that are not one body
  long samples = 0;                 ///< states that were drawn
  SamplingEnd end = SamplingEnd::MostSamples;
};

/// How far the study is, for a progress bar; called in the thread of the caller.
enum class StudyStage : unsigned char { Sampling, Searching };
using StudyProgress = std::function<void(StudyStage, double done)>;  ///< done: from 0 to 1

/// Finds out which pairs of links touch in which states.
///
/// First, random states: joints uniform within their ranges. A pair that was seen in contact and apart is left alone
/// from then on. The states end early once kQuietSamples of them in a row changed the class of no pair. By the rule
/// of three a pair's other kind of state then has, at 95 % confidence for each pair by itself, a share of less than
/// kUnseenShare: n independent states all miss a share p with the probability (1 - p)^n < exp(-n p), 5 % for n p = 3.
/// Second, what random states miss: from the closest state of a pair that was never in contact, a coordinate descent of
/// the distance, and an ascent for one that always was. Third, a proof for what is never in contact still, see
/// proveSeparation().
///
/// States are drawn in blocks of one size, each from a seed of its own, and what has been learned counts from one round
/// of blocks to the next: so the result is the same for any number of threads.
PairStudy studyPairs(const std::shared_ptr<const scene::SceneModel>& model, const StudyOptions& options,
                     const StudyProgress& progress = {});

}  // namespace proximity_server::tools
