#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "proximity_server/scene/motion/moving_scene.h"
#include "scene/motion/moving_bodies.h"
#include "scene/query/interior_search.h"
#include "scene/query/pair_ranking.h"
#include "scene/query/volumes.h"

namespace proximity_server::scene {

/// Answers questions about pairs of shapes in motion. It divides volumes and time together, and the narrowphase
/// computes only the pieces and intervals that neither spheres nor boxes settle.
///
/// What is wholly inside a closed mesh is so from the start, or has come there through a contact of pieces. So interiors
/// matter to a first contact at the start only, and to a minimum only if it is no more than 0.
class MotionSearch {
 public:
  MotionSearch(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Volumes> volumes);

  const std::shared_ptr<const SceneModel>& model() const { return model_; }
  const std::shared_ptr<const Volumes>& volumes() const { return volumes_; }

  RobotContact firstContact(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question);
  RobotMinimum minimum(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question);

 private:
  struct MovingPair {
    ShapeRefPair asked;
    double padding;  ///< [m]
    int a, b;        ///< volumes
    MovingBodies bodies;
  };

  /// Two volumes during an interval of time, see MovingBodies::Interval.
  struct IntervalVisit {
    double lower_bound;  ///< [m] of their signed distance less the padding
    int pair;            ///< index into moving_pairs_
    int a, b, interval;
    double travel;  ///< [m] of b as seen from a
  };
  /// What a search knows so far about the time of the first contact.
  struct FirstContactBounds {
    double latest = 1.0;                                          ///< of a contact that was found, or the end
    double undecided = std::numeric_limits<double>::infinity();   ///< from then on a pair may be in contact, undecided
    narrowphase::Status status = narrowphase::Status::Converged;  ///< the reason why it is undecided
    void leaveOpen(double time, narrowphase::Status why);
  };
  enum class Order : unsigned char { Nearest, Earliest };

  void begin(const Pairs& pairs, const RobotMotion& motion, Order order, MotionCounts& counts);
  int enterAll(double limit);
  MovingPair& movingPairOf(const IntervalVisit& visit) { return moving_pairs_[visit.pair]; }
  const Piece& pieceOf(int leaf) const;

  bool goesLater(const IntervalVisit& p, const IntervalVisit& q) const;
  void push(const IntervalVisit& visit);
  IntervalVisit pop();

  IntervalVisit withSpheres(IntervalVisit visit);
  IntervalVisit withBoxes(IntervalVisit visit);
  const Volume& at(int volume) const { return (*volumes_)[volume]; }
  bool isLeaf(const IntervalVisit& visit) const { return at(visit.a).isLeaf() && at(visit.b).isLeaf(); }
  void split(const IntervalVisit& visit, double limit);

  bool hasInterior(const MovingPair& moving) const { return haveInterior(at(moving.a), at(moving.b)); }
  void considerStart(const MotionQuestion& question, FirstContactBounds& bounds, RobotContact& answer);
  IntervalVisit withInterior(IntervalVisit visit, RobotMinimum& answer);
  void searchInteriors(const MotionQuestion& question, RobotMinimum& answer);
  void considerStates(const Pairs& pairs, RobotMinimum& answer);
  narrowphase::TimeOfContact contactOf(const IntervalVisit& visit, const MotionQuestion& question, double latest);
  void measure(const IntervalVisit& visit, const MotionQuestion& question, FirstContactBounds& bounds,
               RobotContact& answer);
  narrowphase::MinimumOverMotion minimumOf(const IntervalVisit& visit, const MotionQuestion& question,
                                           double upper_bound);
  PairProximity found(const IntervalVisit& visit, narrowphase::SignedDistance result, double time);

  const std::shared_ptr<const SceneModel> model_;
  const std::shared_ptr<const Volumes> volumes_;
  PairPaddings paddings_;
  PairRanking states_;  ///< answers about the state at one time
  std::vector<MovingPair> moving_pairs_;
  std::optional<PosesInTime> poses_;
  Order order_ = Order::Nearest;
  std::vector<IntervalVisit> queue_;  ///< a heap
};

}  // namespace proximity_server::scene
