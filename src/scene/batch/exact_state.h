#pragma once

#include "proximity_server/scene/model/states.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/batch/batch_model.h"
#include "scene/query/pair_measurement.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// True if two states are as near each other as two that follow each other along an edge.
bool areNear(const States& states, Eigen::Index a, Eigen::Index b);

/// Answers questions about one state after the other exactly: bit for bit as a Scene that has seen nothing before, but
/// for the iterations, and for the bound that proves a pair beyond a threshold. It does only the work that the asked
/// pairs need:
///
/// 1. place() stores where the positions are in memory.
/// 2. A question places the two bodies of its pair and the bodies that carry them, unless an earlier question about
///    this state has placed them. The poses are the same as by forwardKinematics().
/// 3. PairMeasurement answers. If the state is near the last one, as along an edge, it computes the pieces first that
///    were the closest there, and begins where the searches ended there. No answer depends on that.
///
/// Pairs are numbers among BatchModel::pairs. After construction nothing is allocated, except if the search of
/// pieces needs a longer queue than ever before.
class ExactState {
 public:
  explicit ExactState(std::shared_ptr<const BatchModel> batch);

  /// Takes a row of the states, which must stay in its place until the last question about it. Its positions must be
  /// finite.
  void place(const States& states, Eigen::Index state);

  /// True if the pair counts as at or below the distance [m]. It does unless its lower bound proves otherwise, as
  /// Scene::below() decides it. The distance itself is not computed, which costs less.
  bool isBelow(int pair, double distance);

  /// Both steps of isBelow(), for a search of many pairs. The first one returns the pair with the lower bound of its
  /// spheres and boxes, unless this is above the distance, or the pair is Unknown. The second one decides by the pieces.
  std::optional<Visit> boundedWithin(int pair, double distance);
  bool isBelow(const Visit& bounded, double distance) { return !measurement_->arePiecesBeyond(bounded, distance); }

  /// The answer of Scene::proximity() with this Question::threshold [m].
  PairProximity proximity(int pair, double threshold = std::numeric_limits<double>::infinity());

  /// That of the less exact one of two parts.
  Representation representationOf(const PartPair& pair) const;

  // The following functions answer in steps, for a search of many pairs. A visit is one of BatchModel::visits with a
  // lower bound that the caller knows.

  /// Places the bodies of the pair. Returns false if the pose of one is missing because it is not finite: then the pair
  /// is Unknown.
  bool isPlaced(const Visit& visit);

  /// True if no pair is Unknown. Positions may be finite and a pose not.
  bool isPlaced();

  /// Raises the lower bound, unless it is above the limit [m]: with a bound that was kept in an earlier state minus a
  /// bound on the motion since then, or with the boxes of both links.
  Visit refined(Visit visit, double limit) const;

  /// Like proximity(), if isPlaced(). If a lower bound of the distance is above the limit [m], that bound is enough.
  PairProximity measure(const Visit& visit, double limit);

  /// Keeps a lower bound of the distance [m] that measure() returned, for refined() in the next states along an edge.
  void keepBound(const Visit& visit, double lower_bound);

  /// Like measure() for another question than the default one.
  PairProximity measure(const Visit& visit, double limit, const Question& question);

  /// True if the state is near the last one for which this was asked or a pair was computed, as along an edge.
  bool isNearLast();

  /// The pose of a body of the robot.
  const Eigen::Isometry3d& poseOf(int body);

 private:
  /// The pieces of a pair that were the closest when it was last computed.
  struct Guess {
    LeafPair leaves;
    std::uint64_t state = 0;
  };

  /// A lower bound of the distance of a pair in an earlier state.
  struct KnownBound {
    RelativePose a_T_b;
    double lower_bound = -std::numeric_limits<double>::infinity();  ///< [m]
  };

  const ShapeRefPair& refsOf(int pair) const { return batch_->pairs[pair]; }
  const Visit& visitOf(int pair) const { return batch_->visits[pair]; }
  void takeStep();
  LeafPair* guessFor(int pair);
  void placePair(int pair);
  void placeSphere(int part);
  void placeOrigin();
  void placeBody(int body);
  void placeFrames();
  double positionOf(int joint) const;

  std::shared_ptr<const BatchModel> batch_;
  std::unique_ptr<PlacedRobot> robot_;
  std::unique_ptr<PairMeasurement> measurement_;
  const double* positions_ = nullptr;
  Eigen::Index stride_ = 0;  ///< from one joint to the next

  /// The number of the current state. Data that belong to it have the same number.
  std::uint64_t state_ = 0;
  std::vector<Eigen::Isometry3d> poses_;  ///< of the bodies
  std::vector<std::uint64_t> pose_of_;    ///< for each body: the state to which its pose belongs
  std::vector<std::uint64_t> body_of_;    ///< for each body: the state in which PlacedRobot has it
  std::vector<std::uint64_t> sphere_of_;  ///< for each root: the state in which PlacedRobot has its sphere
  std::uint64_t origin_of_ = 0;           ///< the state to which the origin of the spheres belongs
  std::uint64_t compared_ = 0;            ///< the state that was last compared with the one before
  std::uint64_t edge_begin_ = 0;          ///< the first state of the edge: then each one is near the one before
  std::vector<double> last_positions_;    ///< in the state that was last compared
  std::vector<Guess> guesses_;            ///< for each pair
  std::vector<KnownBound> known_;         ///< for each pair of links
  FramePoses frames_;                     ///< of moving objects
  std::uint64_t frames_of_ = 0;           ///< the state in which PlacedRobot has them
};

}  // namespace proximity_server::scene
