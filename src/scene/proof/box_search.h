#pragma once

#include "proximity_server/scene/derivative/free_motion.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/proof/pair_proof.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/proof/pair_box.h"

#include <map>
#include <memory>
#include <tuple>

namespace proximity_server::scene {

/// The working memory of one thread, for the boxes of one pair after the other.
class BoxMeasures {
 public:
  BoxMeasures(const std::shared_ptr<const SceneModel>& model, const std::shared_ptr<const Objects>& objects);

  /// Begins with a pair: nothing is left of the pairs before, so that the answers do not depend on them.
  void begin(const Scene& scene) { scene_ = scene.forAnotherThread(); }

  /// Takes a state, and how far each joint may be off.
  void update(const Positions& positions);

  Scene& scene() { return scene_; }
  const State& state() const { return state_; }
  GuaranteedDistances& bounds() { return bounds_; }

  /// By leader of joints, an upper bound of the travel of all points of a pair [m/rad] or [m/m]; false if there is
  /// none.
  bool findTravel(const ShapeRefPair& pair);
  double travelOf(int joint) const { return weights_[state_.degreesOfFreedom().columnsOf(joint).first]; }

 private:
  State state_;
  Scene scene_;
  GuaranteedDistances bounds_;
  FreeMotion travel_;
  Eigen::VectorXd weights_;
};

/// The branch and bound of one pair; see proveApart().
class BoxSearch {
 public:
  /// The question and the box must outlive it. Throws std::invalid_argument as pairBox() does.
  BoxSearch(const SceneModel& model, const ShapeRefPair& pair, const JointBox& box, const ProofQuestion& question);

  /// Examines boxes until the pair is settled, `most_boxes` have been examined in all, or the deadline has come.
  void run(BoxMeasures& measures, long most_boxes);

  /// Ends the search: the signed distance [m] is at least `bound` in the whole box.
  void settle(double bound);

  bool isSettled() const;
  PairProof result() const;

 private:
  /// A part of the box.
  struct Box {
    JointBox joints;
    double bound;  ///< [m] a lower bound of the distance
    double share;  ///< of the volume of the whole box
    int widest;    ///< the place of the joint along which it is divided; -1: it cannot be divided
  };

  double contact() const { return question_.contact_distance; }
  bool wantsShares() const { return question_.goal == ProofQuestion::Goal::Shares; }
  double target() const;
  void divide(BoxMeasures& measures);
  void examine(Box box, BoxMeasures& measures);
  void placeAtCentre(const JointBox& box);
  Uncertainty halfWidths(const JointBox& box) const;
  narrowphase::SignedDistance measure(BoxMeasures& measures, PairProximity& found);
  void tryCorners(const PairProximity& found, BoxMeasures& measures);
  bool isInContact(const JointBox& box, double upper_bound, const BoxMeasures& measures) const;

  const SceneModel& model_;
  const ShapeRefPair pair_;
  const ProofQuestion& question_;
  const PairBox whole_;
  Positions positions_;  ///< of the state that is examined
  /// Those that are not settled, in the order in which they are divided.
  std::map<std::tuple<double, double, long>, Box> boxes_;
  double settled_bound_;  ///< [m] the smallest of all boxes that are settled
  PairProof proof_;
};

}  // namespace proximity_server::scene
