#pragma once

#include "proximity_server/scene/guaranteed/reached_state.h"
#include "scene/guaranteed/displaced_pair.h"
#include "scene/guaranteed/divided.h"
#include "scene/guaranteed/limited_work.h"
#include "scene/guaranteed/pieces_bound.h"
#include "scene/guaranteed/reached.h"
#include "scene/uncertainty/uncertain_places.h"

#include <vector>

namespace proximity_server::scene {

/// Bounds the distance of one pair after the other over an uncertainty; see GuaranteedDistances.
class PairBounds {
 public:
  PairBounds(const SceneModel& model, UncertainPlaces& places);

  void divideInto(int most_parts) { divided_.divideInto(most_parts); }
  void limit(const GuaranteeLimits& limits);
  LimitedWork& work() { return work_; }

  // The state is the one of the places.
  double of(const PairProximity& pair, double enough);
  const ReachedState* reached(const PairProximity& pair, double threshold);

  /// Forgets the bounds of the last state.
  void forgetState() { bounded_.clear(); }
  /// Forgets what makes the next bounds cheaper.
  void forget();

 private:
  double boundOf(const PairProximity& pair, double enough);

  LimitedWork work_;
  DisplacedPair pair_;  ///< the one that is looked at
  PiecesBound pieces_;
  ReachedStates reached_;
  DividedBound divided_;

  /// A bound of this state, which was improved up to `enough`.
  struct Bounded {
    ShapeRefPair pair;
    double enough, bound;
  };
  std::vector<Bounded> bounded_;
};

}  // namespace proximity_server::scene
