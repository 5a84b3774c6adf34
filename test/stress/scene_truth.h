#pragma once

#include "oracle/shape_pairs.h"
#include "stress/scene_cells.h"

#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace proximity_server::scene {

using narrowphase::DistanceBounds;

constexpr long double kFar = std::numeric_limits<long double>::infinity();

/// Two convex parts with bounds of their signed distance.
struct PartsApart {
  const WorldPart* a = nullptr;
  const WorldPart* b = nullptr;
  Eigen::Isometry3d a_T_b{};
  DistanceBounds distance{kFar, kFar};
};

/// Bounds of the distance of a pair of links or objects.
struct PairTruth {
  ShapeRefPair pair;
  bool is_known = false;
  DistanceBounds distance{kFar, kFar};
  PartsApart nearest{};  ///< of the parts; none if a plane is nearer, or the inside of a mesh
};

bool hasObject(const ShapeRefPair& pair);
bool isOfKind(const ShapeRefPair& pair, PairKind kind);

/// The signed distances of all checked pairs of a cell where it is placed now.
///
/// Method: poses in long double from the descriptions; refinedTruth() of each pair of parts that are near each other,
///         the distance of spheres about those that are not. In overlap the upper bound is that of signedDistance(),
///         which has a stress run of its own.
class StateTruth {
 public:
  explicit StateTruth(SceneCell& cell);

  const std::vector<PairTruth>& pairs() const { return pairs_; }

  /// nullptr for a pair that is not checked.
  const PairTruth* find(const ShapeRefPair& pair) const;

  /// Returns the bounds of one pair, whether it is checked or not.
  PairTruth of(const ShapeRefPair& pair);

  const std::optional<WorldSolid>& solidOf(const ShapeRef& ref);

 private:
  using Names = std::tuple<int, int, int, int>;
  static Names namesOf(const ShapeRefPair& pair);

  SceneCell& cell_;
  std::map<std::pair<int, int>, std::optional<WorldSolid>> solids_;
  std::vector<PairTruth> pairs_;
  std::map<Names, int> known_;
};

/// Computes the distance of two parts by rational numbers, or by branch and bound.
DistanceBounds byOracle(const PartsApart& parts);

/// "l1 and object 3"
std::string nameOf(const SceneCell& cell, const ShapeRefPair& pair);

/// " by 1.5e-09 m"
std::string by(long double metres);

/// Returns the promise that a result about a pair does not keep, or "". The poses that the result was computed from may
/// be off by `rounding` [m].
std::string problemOf(const narrowphase::SignedDistance& result, const PairTruth& truth, double tolerance,
                      double rounding = 0.0);

}  // namespace proximity_server::scene
