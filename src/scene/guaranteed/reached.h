#pragma once

#include "proximity_server/scene/guaranteed/reached_state.h"
#include "scene/guaranteed/displaced_pair.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::scene {

/// Finds states within the uncertainty in which a pair is close.
class ReachedStates {
 public:
  ReachedStates(const UncertainPlaces& places, DisplacedPair& pair);

  /// Displaces all so that two points come together, and measures the distance of their pieces [m] in that state. Then
  /// `where` tells what is the closest there, relative to the present state; without a normal if that is not known.
  double bringTogether(DisplacedPair::Where& where);

  /// Finds a state in which the pair is below the threshold [m]: the present one, in which it has this upper bound, or
  /// that with the leaders at these positions relative to the present ones, or one in which two points come together.
  /// nullptr if none is found. Valid until the next call.
  const ReachedState* find(double threshold, double upper_bound, const std::vector<double>& leaders,
                           const DisplacedPair::Where& deciding);

 private:
  /// The displacements of one place in a state.
  struct Moved {
    double position = 0.0;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero(), origin = Eigen::Vector3d::Zero();
    Eigen::Isometry3d displacement = Eigen::Isometry3d::Identity();
  };

  void displace(const Displacement& own, const Eigen::Vector3d& point, const Eigen::Vector3d& towards);
  void moveLeaders(const std::vector<double>& positions);
  Eigen::Isometry3d motionOf(const DisplacedShape& shape) const;
  double upperBoundDisplaced(DisplacedPair::Where& where);
  bool isReachedBelow(double threshold, const LeafPair& leaves);
  void placeDisplaced();

  const UncertainPlaces& places_;
  DisplacedPair& pair_;
  std::vector<Moved> moved_;     ///< by body; then the two shapes, if they are objects
  std::vector<double> closing_;  ///< by leader, the change of the gap to first order, and then its position
  ReachedState reached_;
};

}  // namespace proximity_server::scene
