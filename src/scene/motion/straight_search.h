#pragma once

#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/motion/robot_motion.h"
#include "scene/bounds/heap.h"
#include "scene/motion/moving_pairs.h"
#include "scene/query/interior_search.h"
#include "scene/query/pair_ranking.h"
#include "scene/state/volumes.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// The less complete of two statuses: Unknown, or else the one that comes later in the enumeration.
inline narrowphase::Status lessComplete(narrowphase::Status p, narrowphase::Status q) {
  return std::min(p, q) == narrowphase::Status::Unknown ? narrowphase::Status::Unknown : std::max(p, q);
}

/// Answers questions about pairs of shapes in a straight motion. It divides volumes and time together, and the narrowphase
/// computes only the pieces and intervals that neither spheres nor boxes settle. The tree of fixed objects is divided
/// in the same way; it forms one pair with each link.
///
/// A shape that is wholly inside a closed mesh was there at the start, or a contact of pieces came before. So interiors
/// matter to the time of contact at the start only, and to a minimum only if it is at most 0. A fixed object that is
/// not examined is too far away to matter, and so is its interior.
class StraightSearch {
 public:
  /// With the model and the objects of a state, whose poses do not matter.
  explicit StraightSearch(State state);

  const State& state() const { return state_; }

  void use(std::shared_ptr<const Objects> objects);
  const std::shared_ptr<const Objects>& objects() const { return pairs_.objects(); }

  RobotTimeOfContact timeOfContact(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question);
  RobotMinimum minimum(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question);

  /// Like timeOfContact(), but each distance is smaller by the most that the deviations can change it: without contact,
  /// no motion within them leads to one. Shapes inside a closed mesh are looked for at the start of the motion only.
  RobotTimeOfContact timeOfContact(const Pairs& pairs, const RobotMotion& motion, const JointDeviations& deviations,
                                   const MotionQuestion& question);

  /// The minimum of these smaller distances; it is searched only below `limit` [m]. The distance of the pair in the
  /// answer is taken in the motion.
  RobotMinimum minimumBelow(double limit, const Pairs& pairs, const RobotMotion& motion,
                            const JointDeviations& deviations, const MotionQuestion& question);

  /// The closest pair at the start of a motion, of those that are measured before the deadline. nullopt: none is known,
  /// or the pose of the world is not.
  std::optional<PairProximity> closestAtStart(const Pairs& pairs, const RobotMotion& motion, const Deadline& deadline);

  /// A pair that may be the nearest one during a motion.
  struct OpenPair {
    ShapeRefPair pair;
    double lower_bound;  ///< [m] of its smaller distances
  };
  /// The pairs of the last minimumBelow(). Those that are left out are farther apart than its limit during the whole
  /// motion. nullopt: the last search had too many of them with fixed objects.
  std::optional<std::vector<OpenPair>> openPairs();

 private:
  /// Two volumes during an interval of time, see MovingBodies::Interval; or a volume and a node of the tree.
  struct IntervalVisit : PartPair {
    double lower_bound;  ///< [m] of their signed distance minus the padding
    int pair;            ///< index into pairs_
    MovingBodies::Interval interval;
    double travel = 0.0;    ///< [m] of b as seen from a; of an interior from the middle of the interval
    double earliest = 0.0;  ///< the begin of the interval for a search in Order::Earliest; push() sets it

    bool operator<(const IntervalVisit& other) const {
      return earliest != other.earliest ? earliest > other.earliest : lower_bound > other.lower_bound;
    }
  };
  /// The bounds of the time of contact that a search has found so far.
  struct TimeOfContactBounds {
    double latest = 1.0;  ///< the time of a contact that was found, or the end
    /// from this time on it is not decided whether a pair is in contact
    double undecided = std::numeric_limits<double>::infinity();
    narrowphase::Status status = narrowphase::Status::Converged;  ///< the reason why it is undecided
    void leaveOpen(double time, narrowphase::Status why);
  };
  enum class Order : unsigned char { Nearest, Earliest };

  enum class States : unsigned char { Seen, NotSeen };

  void begin(const Pairs& pairs, const RobotMotion& motion, const JointDeviations& deviations,
             const MotionQuestion* contact, MotionCounts& counts,
             double limit = std::numeric_limits<double>::infinity());
  void searchMinimum(States at_start, const MotionQuestion& question, RobotMinimum& answer);
  std::int64_t unknownPairsWithObjects();
  void enterAll(double limit);
  IntervalVisit wholeMotionOf(int pair) {
    return {{pairs_[pair].a.root, pairs_[pair].b.root},
            -std::numeric_limits<double>::infinity(),
            pair,
            MovingBodies::Interval(1)};
  }
  PairInMotion& movingPairOf(const IntervalVisit& visit) { return pairs_[visit.pair]; }
  bool isSettled(const IntervalVisit& visit, double limit) {
    return visit.lower_bound > std::min(limit, movingPairOf(visit).contact_distance);
  }

  void push(IntervalVisit visit);
  void settle(const IntervalVisit& visit);
  bool openObjectsBelow(const IntervalVisit& visit);
  void noteQueue(double limit);

  IntervalVisit withSpheres(IntervalVisit visit);
  IntervalVisit withBoxes(IntervalVisit visit);
  bool isLeaf(const IntervalVisit& visit);
  void enter(IntervalVisit visit, double limit);
  void enterHalves(const IntervalVisit& visit, double limit);
  void split(const IntervalVisit& visit, double limit);
  void splitFixedObjects(const IntervalVisit& visit, double limit);

  static bool hasInterior(const PairInMotion& moving);
  bool hasInteriors(const Pairs& pairs) const;
  bool hasInterior(const ShapeRef& ref) const;
  void considerStart(const Pairs& pairs, const MotionQuestion& question, TimeOfContactBounds& bounds,
                     RobotTimeOfContact& answer);
  void considerObjectsAtStart(const Pairs& pairs, const MotionQuestion& question, TimeOfContactBounds& bounds,
                              RobotTimeOfContact& answer);
  IntervalVisit withInterior(IntervalVisit visit, RobotMinimum& answer);
  static bool isVain(const IntervalVisit& visit, double upper_bound, const MotionQuestion& question);
  void searchInteriors(const MotionQuestion& question, RobotMinimum& answer);
  bool isInWorld();
  void placeStates(double time);
  bool considerStates(const Pairs& pairs, const Deadline& deadline, RobotMinimum& answer);
  double roundingAtStart();
  PairProximity inPosesFrame(const PairProximity& in_world, double time);
  void follow(const PairInMotion& moving, const Piece& a, const Piece& b);
  narrowphase::TimeOfContact timeOfContactOf(const IntervalVisit& visit, const MotionQuestion& question, double latest);
  void measure(const IntervalVisit& visit, const MotionQuestion& question, TimeOfContactBounds& bounds,
               RobotTimeOfContact& answer);
  double searchPieces(const MotionQuestion& question, RobotMinimum& answer);
  narrowphase::MinimumOverMotion minimumOf(const IntervalVisit& visit, const MotionQuestion& question,
                                           double upper_bound);
  PairProximity inPosesFrame(const IntervalVisit& visit, const narrowphase::SignedDistance& in_middle, double time);
  PairProximity ofAllPieces(PairProximity pair, double time);

  State state_;         ///< at one time of the motion
  PairRanking states_;  ///< answers questions about it
  MovingPairs pairs_;
  bool found_pieces_ = false;  ///< true if the last pair was measured by two of several pieces
  bool are_open_pairs_known_ = false;
  bool links_have_interiors_ = false, objects_have_interiors_ = false;
  std::vector<IntervalVisit> settled_nodes_;    ///< nodes of the tree of fixed objects that enter() left out
  narrowphase::MotionChain chain_a_, chain_b_;  ///< of two pieces; kept for their memory
  Order order_ = Order::Nearest;
  Heap<IntervalVisit> queue_;
};

}  // namespace proximity_server::scene
