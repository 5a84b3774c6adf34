#pragma once

#include "proximity_server/scene/query/pair_distances.h"
#include "scene/bounds/bounds.h"
#include "scene/guaranteed/limited_work.h"
#include "scene/query/closest_pieces.h"
#include "scene/uncertainty/uncertain_places.h"

#include <vector>

namespace proximity_server::scene {

/// The two shapes of a pair with all that displaces them relative to each other. The second shape of the pair is `a` if
/// the first one has half-spaces.
class DisplacedPair {
 public:
  DisplacedPair(const SceneModel& model, UncertainPlaces& places, LimitedWork& work);

  /// Takes a pair. Returns false if a pose is missing.
  bool begin(const ShapeRefPair& pair);

  /// Takes other poses of `a` and `b`.
  void place();

  /// Two pieces that are bounded along a direction, and where that is attained.
  struct Where {
    LeafPair leaves;
    Eigen::Vector3d normal, point_a, point_b;  ///< in the frame of the poses
  };
  /// The gap of two pieces along a direction, now and over all displacements [m].
  struct Along {
    double present, bound;
    double loss;  ///< [m] to first order, of the points that are the closest now
    int frame;
    Where where;
  };
  /// The gap along a unit vector, with the displacements as they are seen from one of the frames.
  Along along(const LeafPair& leaves, const Eigen::Vector3d& normal, int frame);

  /// Tries other frames and directions, until the bound is `enough` [m]. `negligible` [m] is not worth the steps.
  void improve(Along& best, double enough, double negligible);

  /// The distance of two pieces, or of a piece and a half-space, in the frame of the body of a.
  narrowphase::SignedDistance measured(const LeafPair& leaves, const RelativePose& a_T_b, double stop_above);

  static RelativePose relative(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    RelativePose a_T_b;
    a_T_b.rotation.noalias() = a.linear().transpose() * b.linear();
    a_T_b.translation.noalias() = a.linear().transpose() * (b.translation() - a.translation());
    return a_T_b;
  }

  /// [m] What brings the surfaces closer, though no point moves.
  double surfaces() const { return padding + swelling; }
  /// [m] How far all points move at most.
  double travel() { return chains(frame).of_a.travel() + chains(frame).of_b.travel() + swelling; }
  double rounding() const { return PlacedRobot::rounding(a.part.whole(), b.part.whole(), a_T_b); }
  bool hasInterior() const { return a.part.whole().has_interior || b.part.whole().has_interior; }

  /// The displacements of the two as they are seen from one of three frames. If a face meets a corner, the frame of
  /// the face is the best one: the corner moves, and the face does not turn.
  static constexpr int kCommon = 0, kOfA = 1, kOfB = 2, kFrames = 3;
  struct Chains {
    explicit Chains(int groups) : of_a(groups), of_b(groups) {}
    Displacements of_a, of_b;
    bool is_placed = false;
  };
  Chains& chains(int frame);

  /// Counts the work of a direction.
  void countAlong(const Displacements& of, const narrowphase::Shape& shape);

  ShapeRefPair asked;
  DisplacedShape a, b;
  bool is_exchanged = false;
  RelativePose a_T_b;
  double padding = 0.0, swelling = 0.0;
  int frame = kCommon;  ///< the frame of the first bound of all pieces

 private:
  void turn(Along& best, double enough, double negligible);

  UncertainPlaces& places_;
  LimitedWork& work_;
  const PairDistances paddings_;
  std::vector<Chains> chains_;
};

}  // namespace proximity_server::scene
