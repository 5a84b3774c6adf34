#pragma once

#include <memory>
#include <optional>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/query/question.h"
#include "scene/query/closest_pieces.h"
#include "scene/query/pair_memory.h"
#include "scene/query/pair_paddings.h"
#include "scene/query/placed_robot.h"
#include "scene/query/visit_queue.h"

namespace proximity_server::scene {

/// The count of the pairs that such a bound settled.
int& countOf(Visit::Bound bound, PairCounts& counts);

/// Measures pairs one by one, and computes only what it must. It tries what settles a pair from the cheapest to the
/// dearest:
///
/// 1. the spheres around both shapes;
/// 2. the answer of before, less a bound on the motion since, or the answer itself where the two are at rest;
/// 3. the boxes around both shapes;
/// 4. the narrowphase, on the closest pieces of both.
///
/// It counts how each pair was settled.
class PairMeasurement {
 public:
  PairMeasurement(const SceneModel& model, std::shared_ptr<const Volumes> volumes, Skipping skipping);

  void update(const BodyPoses& poses) { robot_.update(poses); }
  const PlacedRobot& robot() const { return robot_; }

  /// The pair with the bound of its spheres; returns nullopt where a pose or all geometry is missing. `number` decides
  /// between equal bounds. The same numbers come out for a pair that is asked in the other order.
  std::optional<Visit> visitOf(const ShapeRefPair& pair, int number) const;

  /// The best bound that costs less than computing, or any that is above the limit [m].
  Visit refined(Visit visit, double limit) const;

  /// Computes a pair, unless its answer of before holds. Beyond the limit [m] only the proof is wanted. Unknown after
  /// the deadline.
  PairProximity measure(const ShapeRefPair& pair, const Visit& visit, double limit, const Question& question);

  /// All of that for one pair: by bounds where they decide the question's threshold, else computed.
  PairProximity settle(const ShapeRefPair& pair, const Question& question);

  /// Whether the answer of before, plus the motion since, proves the signed distance to be at most `threshold` [m].
  bool isStillWithin(const Visit& visit, double threshold) const;

  /// Of all pairs since the caller reset them. A search of many pairs adds those that it settles without measuring.
  PairCounts& counts() { return counts_; }
  const PairCounts& counts() const { return counts_; }

 private:
  /// The last computation of a pair, for later.
  struct KeptAnswer {
    RelativePose a_T_b;
    PairProximity proximity;  ///< in the frame of a
    LeafPair leaves;
  };

  PairProximity proof(const Visit& visit) const;
  std::optional<PairProximity> answerAtRest(const Visit& visit, const RelativePose& a_T_b,
                                            const Question& question) const;
  PairProximity compute(const Visit& visit, const RelativePose& a_T_b, double limit, const Question& question);
  PairProximity asAsked(const ShapeRefPair& pair, const Visit& visit, PairProximity proximity) const;

  const SceneModel& model_;
  const Skipping skipping_;
  PlacedRobot robot_;
  PieceSearch pieces_;
  PairMemory<KeptAnswer> kept_;
  PairPaddings paddings_;
  PairCounts counts_;
};

}  // namespace proximity_server::scene
