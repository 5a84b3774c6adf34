#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "proximity_server/scene/model/states.h"
#include "scene/batch/batch_model.h"
#include "scene/query/pair_measurement.h"

namespace proximity_server::scene {

/// One state after the other, exactly: what a Scene answers that has seen nothing before, bit for bit. It does only what the
/// asked pairs need:
///
/// 1. place() keeps where the positions are.
/// 2. A question places the two bodies of its pair and the bodies that carry them, unless an earlier one about this state
///    has. Body poses are those of forwardKinematics().
/// 3. PairMeasurement answers, without any memory of other answers.
///
/// Pairs are numbers among BatchModel::candidates. Nothing allocates after construction, except that the search of pieces may
/// need a longer queue than ever before.
class ExactState {
 public:
  explicit ExactState(std::shared_ptr<const BatchModel> batch);

  /// Takes a row of the states, which has to stay where it is until the last question about it. Its positions are finite.
  void place(const States& states, Eigen::Index state);

  /// Whether the pair counts as at or below the distance [m]: unless its lower bound proves otherwise, as Scene::below()
  /// decides it. How far it is remains unknown, which costs less.
  bool isBelow(int pair, double distance);

  /// As Scene::proximity() with this Question::threshold [m].
  PairProximity proximity(int pair, double threshold = std::numeric_limits<double>::infinity());

  // The same in steps, for a search of many pairs. A visit is one of BatchModel::visits with a lower bound that the caller
  // knows.

  /// Places the bodies of the pair. False if the pose of one is missing, because it is not finite: then the pair is Unknown.
  bool isPlaced(const Visit& visit);

  /// Whether no candidate pair is Unknown. A position may be finite and a pose not.
  bool isPlaced();

  /// Raises the lower bound by the boxes of both links, unless it is above the limit [m].
  Visit withBoxes(const Visit& visit, double limit) const { return measurement_->refined(visit, limit); }

  /// As proximity(), if isPlaced(). If a lower bound of the distance is above the limit [m], that bound is enough.
  PairProximity measure(const Visit& visit, double limit);

 private:
  const ShapeRefPair& candidate(int pair) const { return batch_->candidates[static_cast<std::size_t>(pair)]; }
  const Visit& visitOf(int pair) const { return batch_->visits[static_cast<std::size_t>(pair)]; }
  void placePair(int pair);
  void placeSphere(int root);
  void placeOrigin();
  void placeBody(int body);
  const Eigen::Isometry3d& poseOf(int body);
  double positionOf(int joint) const;

  std::shared_ptr<const BatchModel> batch_;
  std::unique_ptr<PairMeasurement> measurement_;
  const double* positions_ = nullptr;
  Eigen::Index stride_ = 0;  ///< from one joint to the next

  /// What is known of this state has its number.
  std::uint64_t state_ = 0;
  std::vector<Eigen::Isometry3d> poses_;  ///< of bodies
  std::vector<std::uint64_t> pose_of_;    ///< the state of each
  std::vector<std::uint64_t> body_of_;    ///< the state in which PlacedRobot has the body
  std::vector<std::uint64_t> sphere_of_;  ///< the state in which PlacedRobot has the sphere of a root
  std::uint64_t origin_of_ = 0;           ///< the state of the origin of the spheres
};

}  // namespace proximity_server::scene
