#pragma once

#include "scene/guaranteed/displaced_pair.h"

#include <Eigen/Geometry>

namespace proximity_server::scene {

/// Bounds the distance of a pair over all its displacements, by its pieces.
class PiecesBound {
 public:
  PiecesBound(DisplacedPair& pair, LimitedWork& work) : pair_(pair), work_(work) {}

  /// A direction, and bounds of the whole pair, with which the bounds of its pieces begin.
  struct Known {
    Eigen::Vector3d normal;  ///< of the closest pieces, in the frame of the poses; may be missing
    double lower_bound;      ///< [m] of the whole pair now, or of two of its pieces in the middle of a part
    double loss;             ///< [m] no points of the two come closer by more
    double without_pieces;   ///< [m] a bound of the whole pair; where pieces give a lower one, it is the better one
    double negligible;       ///< [m] is not worth the steps of DisplacedPair::improve()
  };

  /// [m] A lower bound of the distance of all pieces. It is not improved above `enough`.
  double ofAllPieces(const Known& known, double enough);

  /// [m] A lower bound of the distance of what the interior of one part adds: the distance of the balls of the
  /// representatives of the other part, see findInteriorDepths(), along the normal. An interior is in the convex hull
  /// of the pieces.
  double ofInteriors(const Eigen::Vector3d& normal);

  /// The pair of pieces whose bound is the smallest, and where it is attained.
  DisplacedPair::Where deciding;

  /// The pieces that decided the last pair. They are looked at first if the pair is asked for again.
  struct {
    ShapeRefPair pair;
    LeafPair leaves;
  } last_deciding;

 private:
  void findGaps(const Known& known);
  bool hasNormal() const { return known_.normal.allFinite(); }
  double gapAlong(const Volume& a, const Volume& b) const;
  double gapAlong(const LeafPair& leaves) const;
  double ofVolumes(const PartPair& volumes, double enough) const;
  void boundVolumes(const PartPair& volumes, double own, double& lowest);
  void boundPieces(const LeafPair& leaves, double& lowest);
  void boundHalfSpace(int volume, int half_space, double& lowest);

  DisplacedPair& pair_;
  LimitedWork& work_;
  Known known_;
  // Only if there is a normal:
  Eigen::Vector3d in_a_, in_b_;  ///< the normal in the frames of the parts
  double between_ = 0.0;         ///< [m] from the origin of a to the origin of b, along it, less padding and rounding
  double loss_ = 0.0;            ///< [m] no pieces come closer by more along it; infinite for single pieces
  int visits_ = 0;               ///< of pairs of volumes
};

}  // namespace proximity_server::scene
