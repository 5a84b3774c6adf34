#pragma once

#include "proximity_server/scene/guaranteed/reached_state.h"
#include "proximity_server/scene/state/state.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"
#include "scene/guaranteed/displaced_pair.h"
#include "scene/guaranteed/divided.h"
#include "scene/guaranteed/largest_loss.h"
#include "scene/guaranteed/limited_work.h"
#include "scene/guaranteed/pieces_bound.h"
#include "scene/guaranteed/reached.h"
#include "scene/uncertainty/uncertain_places.h"

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// Upper bounds of the ways of shapes, found as far as they have been needed. They are coarser than those of the chain
/// of a pair, and cost much less, because the pairs of a shape share its ways.
class ShapeWays {
 public:
  explicit ShapeWays(UncertainPlaces& places) : places_(places) {}

  /// Forgets all ways, for other poses, objects or uncertainties.
  void forget();

  /// [m] What the points of the two of a pair come closer at most. Infinity for a half-space: no ball contains its
  /// points. NaN if a pose is missing.
  double ofPair(const ShapeRefPair& pair);

 private:
  struct Ways {
    bool is_begun = false;
    Eigen::Vector3d centre;
    double radius, rounding;  ///< [m] of the ball around the shape, and of the distance of its centre from an axis
    int body;                 ///< what displaces it relative to its parent comes next
    std::vector<double> relative_to;  ///< [m] its body, the parent of its body, and so on; NaN: a pose is missing

    void add(const std::vector<Displacement>& displacements, double& sum) const;
  };
  void begin(const ShapeRef& ref, Ways& ways);
  double wayOf(const ShapeRef& ref, std::size_t steps);

  UncertainPlaces& places_;
  std::vector<Ways> ways_;  ///< by the numbers of Volumes
  DisplacedShape seen_;     ///< working memory of begin()
};

/// Bounds the distance of one pair after the other over an uncertainty; see GuaranteedDistances.
class PairBounds {
 public:
  explicit PairBounds(const SceneModel& model, UncertainPlaces& places);

  void divideInto(int most_parts) { divided_.divideInto(most_parts); }
  void limit(const GuaranteeLimits& limits);
  LimitedWork& work() { return work_; }

  // The state is that of the places.
  double of(const PairProximity& pair, double enough);
  const ReachedState* reached(const PairProximity& pair, double threshold);

  /// Forgets the bounds of the last state.
  void forgetState();
  /// Forgets what makes the next bounds cheaper.
  void forget();

 private:
  double boundOf(const PairProximity& pair, double enough);

  UncertainPlaces& places_;
  LimitedWork work_;
  DisplacedPair pair_;  ///< the one that is looked at
  PiecesBound pieces_;
  ReachedStates reached_;
  DividedBound divided_;
  ShapeWays ways_;

  /// A bound of this state, which was improved up to `enough`.
  struct Bounded {
    ShapeRefPair pair;
    double enough, bound;
  };
  std::vector<Bounded> bounded_;
};

}  // namespace proximity_server::scene
