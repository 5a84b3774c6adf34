#include "scene/guaranteed/pieces_bound.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "scene/model/numbers.h"
#include "scene/query/half_space.h"
#include "scene/state/placed_robot.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace proximity_server::scene {

using Eigen::Vector3d;
using narrowphase::SignedDistance;

namespace {

constexpr std::int64_t kStepsOfVisit = 60;  // of LimitedWork, see displaced_pair.cpp

template <class Visit>
void forEachLeaf(const Part& part, int volume, const Visit& visit) {
  if (part[volume].isLeaf()) return visit(part[volume]);
  for (const int each : part[volume].parts) forEachLeaf(part, each, visit);
}

/// [m] How far a piece of a body reaches along a unit vector in the frame of the body.
double reachOf(const Piece& piece, const Vector3d& direction) {
  const Vector3d in_piece = piece.body_T_piece.linear().transpose() * direction;
  int vertex = 0;
  return in_piece.dot(narrowphase::supportPoint(piece.shape, in_piece, vertex)) + piece.shape.margin() +
         direction.dot(piece.body_T_piece.translation());
}

}  // namespace

/// Finds what the normal excludes.
void PiecesBound::findGaps(const Known& known) {
  known_ = known;
  if (!hasNormal()) return;
  in_a_ = pair_.a.pose.linear().transpose() * known_.normal;
  in_b_ = pair_.b.pose.linear().transpose() * known_.normal;
  between_ =
      (pair_.b.pose.translation() - pair_.a.pose.translation()).dot(known_.normal) - pair_.rounding() - pair_.padding;
  loss_ = kInfinity;
  if (pair_.a.part.whole().isLeaf() && pair_.b.part.whole().isLeaf()) return;
  DisplacedPair::Chains& chains = pair_.chains(pair_.frame);
  loss_ = chains.of_a.largestLoss(-known_.normal) + chains.of_b.largestLoss(known_.normal) +
          chains.of_a.remainder(-known_.normal) + chains.of_b.remainder(known_.normal) + pair_.swelling;
}

/// [m] A lower bound of how far two volumes are apart along the normal now.
double PiecesBound::gapAlong(const Volume& a, const Volume& b) const {
  return between_ + in_b_.dot(b.bounds.centre) - in_a_.dot(a.bounds.centre) -
         (a.bounds.axes.transpose() * in_a_).cwiseAbs().dot(a.bounds.half) -
         (b.bounds.axes.transpose() * in_b_).cwiseAbs().dot(b.bounds.half);
}

/// [m] A lower bound of how far two pieces are apart along the normal now.
double PiecesBound::gapAlong(const LeafPair& leaves) const {
  return between_ - reachOf(Leaf(pair_.a.part, leaves.a).piece, in_a_) -
         reachOf(Leaf(pair_.b.part, leaves.b).piece, -in_b_);
}

double PiecesBound::ofAllPieces(const Known& known, double enough) {
  findGaps(known);
  deciding.leaves = {};
  double lowest = enough;
  if (pair_.b.part.isUnbounded())
    for (std::size_t i = 0; i < pair_.b.part.halfSpaces().size(); ++i)
      boundHalfSpace(pair_.a.part.root, static_cast<int>(i), lowest);
  if (pair_.b.part.whole().isEmpty()) return lowest;
  // The pieces that decided the last time are likely to be the lowest ones, and exclude most others.
  if (!(last_deciding.pair.a == pair_.asked.a && last_deciding.pair.b == pair_.asked.b))
    last_deciding = {pair_.asked, {}};
  if (last_deciding.leaves.areLeaves() && !work_.isOver()) boundPieces(last_deciding.leaves, lowest);
  visits_ = 0;
  boundVolumes({pair_.a.part.root, pair_.b.part.root}, -kInfinity, lowest);
  return lowest;
}

/// [m] A lower bound of the distance of the pieces of two volumes. It is not improved above `enough`.
double PiecesBound::ofVolumes(const PartPair& volumes, double enough) const {
  const Volume &a = pair_.a.part[volumes.a], &b = pair_.b.part[volumes.b];
  double bound = hasNormal() ? gapAlong(a, b) - loss_ : -kInfinity;
  if (bound < enough) bound = std::max(bound, sphereGap(a.bounds, b.bounds, pair_.a_T_b) - pair_.padding - known_.loss);
  if (bound < enough) bound = std::max(bound, boxGap(a.bounds, b.bounds, pair_.a_T_b) - pair_.padding - known_.loss);
  return bound;
}

/// Lowers the bound of all pieces to the bound of the pieces of two volumes, which have the bound `own`. After
/// kMostVisits, or when the work of the pair is over, the bounds of what is left are taken as they are.
void PiecesBound::boundVolumes(const PartPair& volumes, double own, double& lowest) {
  if (own >= lowest || lowest <= known_.without_pieces) return;
  if (work_.isOver()) {
    lowest = own;
    return;
  }
  const Volume &a = pair_.a.part[volumes.a], &b = pair_.b.part[volumes.b];
  if (a.isLeaf() && b.isLeaf()) {
    const LeafPair leaves{volumes.a, volumes.b};
    if (leaves == last_deciding.leaves) return;
    const bool is_excluded = hasNormal() && gapAlong(leaves) - loss_ >= lowest;
    if (!is_excluded) boundPieces(leaves, lowest);
    return;
  }
  constexpr int kMostVisits = 1000;
  if (++visits_ > kMostVisits) {
    lowest = own;
    return;
  }
  work_.count(kStepsOfVisit);
  const bool split_a = splitsFirst(a, b);
  std::array<PartPair, 2> parts{volumes, volumes};
  std::array<double, 2> bounds{};
  for (std::size_t i = 0; i < 2; ++i) {
    (split_a ? parts[i].a : parts[i].b) = (split_a ? a : b).parts[i];
    bounds[i] = ofVolumes(parts[i], lowest);
  }
  const std::size_t first = bounds[1] < bounds[0] ? 1 : 0;
  boundVolumes(parts[first], bounds[first], lowest);
  boundVolumes(parts[1 - first], bounds[1 - first], lowest);
}

double PiecesBound::ofInteriors(const Vector3d& normal) {
  if (!normal.allFinite() || pair_.b.part.isUnbounded()) return -kInfinity;
  DisplacedPair::Chains& chains = pair_.chains(pair_.frame);
  const Vector3d from = pair_.a.pose.translation();
  const double margins =
      chains.of_a.remainder(-normal) + chains.of_b.remainder(normal) + pair_.surfaces() + 4.0 * pair_.rounding();
  const auto lowest = [&](Displacements& of, const Part& part, const Vector3d& n, const auto& heightOf) {
    double height = kInfinity;
    forEachLeaf(part, part.root,
                [&](const Volume& leaf) { height = std::min(height, heightOf(of, leaf, part.pieces[leaf.piece], n)); });
    return height;
  };
  const auto solid = [&](Displacements& of, const Volume&, const Piece& piece, const Vector3d& n) {
    pair_.countAlong(of, piece.shape);
    return work_.isOver() ? -kInfinity : of.lowest(piece, n, from).displaced;
  };
  const auto ball = [&](Displacements& of, const Volume& leaf, const Piece& piece, const Vector3d& n) {
    const double radius = std::max(0.0, piece.shape.innerRadius()) + piece.shape.margin();
    return leaf.has_representative ? of.displacedHeight(piece.body_T_piece * piece.shape.centre(), n, from) - radius
                                   : kInfinity;
  };
  double bound = kInfinity;
  if (pair_.b.part.whole().has_interior)
    bound = lowest(chains.of_a, pair_.a.part, -normal, ball) + lowest(chains.of_b, pair_.b.part, normal, solid);
  if (pair_.a.part.whole().has_interior)
    bound = std::min(
        bound, lowest(chains.of_a, pair_.a.part, -normal, solid) + lowest(chains.of_b, pair_.b.part, normal, ball));
  return bound - margins;
}

/// Lowers the bound of all pieces to the bound of two of them.
void PiecesBound::boundPieces(const LeafPair& leaves, double& lowest) {
  DisplacedPair::Along best{
      -kInfinity, -kInfinity, 0.0, pair_.frame, {leaves, Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()}};
  if (hasNormal()) best = pair_.along(leaves, known_.normal, pair_.frame);
  if (best.bound >= lowest) return;
  const double present = best.present;
  if (hasNormal()) pair_.improve(best, lowest, known_.negligible);
  if (best.bound >= lowest) return;
  // [m] Two pieces that are as close as the closest ones along their normal have this normal, too.
  constexpr double kAsClose = 1e-9;
  if (present < known_.lower_bound - kAsClose) {
    const SignedDistance own = pair_.measured(leaves, pair_.a_T_b, lowest + known_.loss);
    if (own.lower_bound - known_.loss >= lowest) return;
    if (own.normal.allFinite()) {
      DisplacedPair::Along along_own = pair_.along(leaves, pair_.a.pose.linear() * own.normal, pair_.frame);
      pair_.improve(along_own, lowest, known_.negligible);
      if (along_own.bound > best.bound) best = along_own;
    }
    best.bound = std::max(best.bound, own.lower_bound - known_.loss);
    if (best.bound >= lowest) return;
  }
  lowest = best.bound;
  deciding = best.where;
}

void PiecesBound::boundHalfSpace(int volume, int number, double& lowest) {
  const PlacedHalfSpace& half_space = pair_.b.part.halfSpaces()[number];
  const Volume& a = pair_.a.part[volume];
  const double rounding = pair_.rounding();
  const double own = halfSpaceGap(a, half_space, pair_.a_T_b, rounding) - pair_.padding - known_.loss;
  if (own >= lowest) return;
  work_.count(kStepsOfVisit);
  if (work_.isOver()) {
    lowest = own;
    return;
  }
  if (!a.isLeaf()) {
    for (const int part : a.parts) boundHalfSpace(part, number, lowest);
    return;
  }
  const Vector3d up = (pair_.b.pose.linear() * half_space.normal).normalized(), from = pair_.b.pose.translation();
  Displacements& of_a = pair_.chains(DisplacedPair::kOfB).of_a;
  const Piece& piece = pair_.a.part.pieces[a.piece];
  pair_.countAlong(of_a, piece.shape);
  const Displacements::Lowest found = of_a.lowest(piece, up, from);
  const double bound = found.displaced - half_space.offset - of_a.remainder(up) - 2.0 * rounding - pair_.surfaces();
  if (bound >= lowest) return;
  lowest = bound;
  LeafPair leaves;
  leaves.a = volume;
  leaves.half_space = number;
  const Vector3d below = found.point - (up.dot(found.point) - half_space.offset) * up;
  deciding = {leaves, -up, from + found.point, from + below};
}

}  // namespace proximity_server::scene
