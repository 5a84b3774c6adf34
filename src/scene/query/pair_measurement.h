#pragma once

#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/query/closest_pieces.h"
#include "scene/state/pair_memory.h"
#include "scene/state/placed_robot.h"
#include "scene/state/visit_queue.h"

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// The counter of the pairs that bounds of this kind settled.
int& countOf(Visit::Bound bound, PairCounts& counts);

struct DistanceBounds {
  double lower, upper;  ///< [m]
};

/// Measures pairs one by one, and computes as few as possible. The steps are tried from the cheapest to the most
/// expensive:
///
/// 1. the bounding spheres of both shapes;
/// 2. the kept answer minus a bound on the motion since then, or the kept answer itself if the two are at rest;
/// 3. the bounding boxes of both shapes;
/// 4. the interiors of closed meshes and the closest pieces of both, by the narrowphase.
///
/// Spheres and boxes of whole shapes are convex, so they contain the interiors too.
///
/// All steps count the pairs that they settle.
class PairMeasurement {
 public:
  PairMeasurement(const SceneModel& model, Skipping skipping, Memory memory = Memory::OfAnswers);

  /// Answers about the poses of this robot from now on; to be called before the first question, and when the poses or
  /// the objects have changed. Forgets the answers about objects that have changed.
  void see(const PlacedRobot& robot);
  const PlacedRobot& robot() const { return *robot_; }

  /// Returns the pair with the bound of its spheres, or nullopt if a pose or all geometry is missing. `number` decides
  /// between equal bounds. The visit may have the two in the opposite order: the numbers are the same, in whichever
  /// order a pair is asked.
  std::optional<Visit> visitOf(const ShapeRefPair& pair, int number) const {
    return visitOf(pair, {robot_->numberOf(pair.a), robot_->numberOf(pair.b)}, number);
  }

  /// Returns the visit of a pair whose two parts, in any order, are known already.
  std::optional<Visit> visitOf(const ShapeRefPair& pair, const PartPair& parts, int number) const;

  /// Improves the bound of a visit by the steps that cost less than computing, until it is above the limit [m].
  Visit refined(Visit visit, double limit);

  /// Computes a pair, unless its kept answer still holds. Beyond the limit [m] a proof is enough. After the deadline
  /// the answer is Unknown. `guess`, if given, are pieces that may be the closest; with Memory::None the answer does not
  /// depend on them. They become the closest ones, if any were computed.
  PairProximity measure(const ShapeRefPair& pair, const Visit& visit, double limit, const Question& question,
                        LeafPair* guess = nullptr);

  /// Answers a question about one pair with all steps: by bounds if they decide the question's threshold, otherwise it
  /// is computed. `guess` is as in measure().
  PairProximity settle(const ShapeRefPair& pair, const Question& question, LeafPair* guess = nullptr);

  /// True if the lower bound of a pair is above `distance` [m]. The result is the same as by settle() with this
  /// threshold, but the distance of nearer pairs is not computed. `visit`: the pair with the bound of its spheres.
  bool isProvenBeyond(const Visit& visit, double distance);

  /// The last step of isProvenBeyond(), if no bound of a whole is above `distance`: the interiors and the pieces.
  bool arePiecesBeyond(const Visit& visit, double distance);

  /// The bounds that interiors add to the distance of a pair, see findInteriorDepths(); infinite if that distance is
  /// not below `within` [m].
  DistanceBounds interiorOf(const ShapeRefPair& pair, double within) const;

  /// True if the kept answer plus a bound on the motion since then proves a signed distance of at most `threshold` [m].
  bool isStillWithin(const Visit& visit, double threshold) const;

  /// The counts of all pairs since the caller reset them. A search of many pairs adds the pairs that it settles itself.
  PairCounts& counts() { return counts_; }
  const PairCounts& counts() const { return counts_; }

 private:
  void take(std::shared_ptr<const Objects> objects);

  /// The last computed answer about a pair.
  struct KeptAnswer {
    RelativePose a_T_b;
    PairProximity in_body_a;
    LeafPair leaves;
  };

  const KeptAnswer* keptOf(const Visit& visit) const {
    return memory_ == Memory::None ? nullptr : kept_.find(visit.a, visit.b);
  }
  PlacedPair placed(const Visit& visit, const RelativePose& a_T_b) const {
    return {(*robot_)[visit.a], (*robot_)[visit.b], a_T_b, visit.padding, visit.threshold};
  }
  // PairProximity has the frame of the body of a in the following functions; asAsked() transforms it into the frame of
  // the poses.
  std::optional<PairProximity> answerAtRest(const Visit& visit, const RelativePose& a_T_b,
                                            const Question& question) const;
  PairProximity compute(const Visit& visit, const RelativePose& a_T_b, double limit, const Question& question,
                        LeafPair* guess);
  PairProximity asAsked(const ShapeRefPair& pair, const Visit& visit, const PairProximity& in_body_a) const;

  const SceneModel& model_;
  const Skipping skipping_;
  const Memory memory_;
  const PlacedRobot* robot_ = nullptr;
  std::shared_ptr<const Objects> objects_;  ///< to which the kept answers belong
  PieceSearch pieces_;
  PairMemory<KeptAnswer> kept_;
  PairDistances paddings_;
  PairCounts counts_;
};

}  // namespace proximity_server::scene
