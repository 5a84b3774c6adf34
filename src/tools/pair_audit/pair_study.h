#pragma once

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/levels/always_near.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "tools/program/time_budget.h"
#include "tools/robot/robot_text.h"

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::tools {

/// Whether two links are near, which is within PairEvidence::near, over all states that were seen.
enum class NearClass : unsigned char {
  Always,
  Never,
  Sometimes,
  Undecided  ///< always or never in the states seen, but not all was looked at: see has_known_ranges and is_searched
};

/// The evidence about the distance of two links that do not belong to one body.
struct PairEvidence {
  scene::ShapeRefPair pair;
  bool are_neighbours = false;     ///< see RobotModel::areNeighbours
  bool has_known_ranges = true;    ///< of all joints between the two, see scene::hasKnownRange()
  double near = kContactDistance;  ///< [m] as in the options; of neighbours, which are near by design, kContactDistance
  double measured = kContactDistance;  ///< [m] at least `near`; `largest` is exact up to it
  long samples = 0;                    ///< random states until both contact and separation had been seen
  bool is_searched = false;            ///< false: the time was over before

  double smallest = std::numeric_limits<double>::infinity();  ///< [m] smallest distance seen; 0: contact
  double largest = -1.0;               ///< [m] largest distance seen, or a value between `measured` and it; 0: contact
  scene::Positions closest, farthest;  ///< the states with these distances
  std::optional<scene::Positions> contact, within, apart;  ///< the first state in contact, near, and not near
  double contact_depth = 0.0;                              ///< [m] penetration depth in the state `contact`
  std::optional<double> proven;                            ///< [m] proven lower bound of the distance; above 0

  NearClass nearClass() const;
  bool isBeyond() const;         ///< never within `measured`
  bool isProvenBeyond() const;   ///< and that is proven
  bool canCollide() const;       ///< was seen in contact, and not in contact
  bool alwaysInContact() const;  ///< over known ranges
};

struct StudyOptions {
  double distance = 0.0;       ///< [m] two links are near up to this distance; 0: in contact
  double warn_distance = 0.0;  ///< [m] the largest distance of a pair is measured up to this one
  long most_samples = 100000;
  long most_boxes = 10000;  ///< of the proof about a pair
  unsigned long seed = 1;
  TimeBudget budget;
  int threads = 1;
};

/// The share of states below which a kind of state may remain unseen, see studyPairs().
constexpr double kUnseenShare = 1e-4;
constexpr long kQuietSamples = 30000;  ///< 3 / kUnseenShare

/// The reason why no more random states were drawn.
enum class SamplingEnd : unsigned char {
  MaxSamples,  ///< the requested number was reached
  Quiet,       ///< no pair changed its class in the last kQuietSamples
  AllKnown,    ///< every pair was seen both in contact and not near
  OutOfTime
};

struct PairStudy {
  std::vector<PairEvidence> pairs;  ///< all pairs of links that have geometry and do not belong to one body
  double near = kContactDistance;   ///< [m] of pairs that are no neighbours, as the next
  double measured = kContactDistance;
  long samples = 0;  ///< the number of states that were drawn
  SamplingEnd end = SamplingEnd::MaxSamples;
  bool is_out_of_time = false;  ///< the budget ended it: another run may see more, or less
};

/// Reports the progress of a study, in the thread of the caller.
enum class StudyStage : unsigned char { Sampling, Searching, Proving };
using StudyProgress = std::function<void(StudyStage, double done)>;  ///< done: from 0 to 1

/// Classifies the pairs of links by whether they are near always, never, or in some states.
///
/// 1. Draw random states, with joints uniform within their ranges. A pair that was seen both in contact and not near is
///    settled. Sampling ends early if kQuietSamples states in a row changed the class of no pair. By the rule of three,
///    the other kind of state then has a share of less than kUnseenShare, at 95 % confidence for each single pair: n
///    independent states all miss a share p with the probability (1 - p)^n < exp(-n p), which is 5 % for n p = 3.
/// 2. Search for states that sampling missed: a coordinate descent of the distance from the closest state of a pair
///    that was never in contact, and an ascent from the farthest state of a pair that was never beyond `measured`.
/// 3. Try to prove that a pair which was never within `measured` or never near never is, and one that was never in
///    contact never is, see scene::proveApart(). A state that refutes it counts as one that was seen.
///
/// States are drawn in blocks of one size, each from a seed of its own, and pairs are settled only between rounds of
/// blocks. So the result is the same for any number of threads. A time budget ends the study early: what it has not
/// searched is Undecided.
PairStudy studyPairs(const std::shared_ptr<const scene::SceneModel>& model, const StudyOptions& options,
                     const StudyProgress& progress = {});

/// The evidence about a pair of the study.
const PairEvidence& evidenceOf(const scene::ShapeRefPair& pair, const PairStudy& study);

/// The pairs that are always within PairEvidence::measured, as far as `pairs` says that they are checked; without
/// neighbours, pairs that are always in contact, and pairs with a joint that can do more than was tried.
std::vector<scene::AlwaysNear> alwaysNear(const PairStudy& study, const scene::PairTable& pairs);

}  // namespace proximity_server::tools
