#pragma once

#include "scene/uncertainty/uncertain_places.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <vector>

namespace proximity_server::scene {

/// Bounds what any checked pair may lose by an uncertainty; see GuaranteedDistances::largestLoss().
///
/// Only what is on the way from one shape of a pair to the other displaces the two relative to each other. So the sum
/// along the longest way between two bodies, each joint, frame and base with the largest radius of all that it carries,
/// is not less than the loss of any pair in any state.
class LargestLoss {
 public:
  explicit LargestLoss(const UncertainPlaces& places) : places_(places) {}

  /// [m] At the present state; during a motion from there in which each joint moves by at most its travel [rad] or [m],
  /// if there is a travel.
  double of(const std::vector<double>& travel);

 private:
  /// The two largest of some numbers that are not negative.
  struct TwoLargest {
    double largest = 0.0, second = 0.0;

    void offer(double value) {
      second = std::max(second, std::min(value, largest));
      largest = std::max(largest, value);
    }
    double sum() const { return largest + second; }
  };
  struct TravelWays {
    double of_all = 0.0, of_slides = 0.0;  ///< [m]
  };

  const State& state() const { return places_.state(); }
  const RobotModel& robot() const { return places_.robot(); }
  void findRadii();
  void reachObjects();
  TravelWays waysOf(const std::vector<double>& travel) const;
  double reachOfBodies(const Eigen::Vector3d& from, double way) const;
  double reachOfFreeObjects(const Eigen::Vector3d& from, int checked_against) const;
  double lossOfObjects() const;
  double lossOfHalfSpaces(const std::vector<double>& travel) const;
  double lossOfBodies(double way_of_slides);
  double lossOfSurfaces() const;

  const UncertainPlaces& places_;
  // Working memory:
  std::vector<double> reach_;         ///< [m] of what each body and its links carry, from its origin
  std::vector<double> radius_;        ///< [m] the same, also of what the bodies behind it carry
  std::vector<TwoLargest> branches_;  ///< [m] the losses along two branches of what each body carries, the roots first
};

}  // namespace proximity_server::scene
