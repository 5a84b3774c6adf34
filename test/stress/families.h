#pragma once

#include "oracle/oracle.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "stress/random_geometry.h"

#include <cstdint>
#include <string>
#include <vector>

namespace proximity_server::narrowphase {

/// One question to the narrowphase, complete: what is asked, and what an earlier query left behind.
struct StressPair {
  Shape a;
  Shape b;
  Eigen::Isometry3d a_T_b;
  Options options;
  WarmStart warm_start;

  ShapePair pair() const { return {a, b, a_T_b}; }
};

/// How two shapes lie, and how they are asked about.
struct Query {
  Eigen::Isometry3d a_T_b;
  Options options;
  WarmStart warm_start;
};

/// Pairs that share one kind of trouble.
struct Family {
  const char* name;
  TwoShapes (*shapes)(Chance&);
  Query (*query)(const TwoShapes&, Chance&);
  int rarity = 1;  ///< a slow family takes part in every so many rounds of a run only
};

const std::vector<Family>& stressFamilies();

/// Hulls are slow to build, so this many pairs in a row share their shapes.
constexpr std::int64_t kPairsPerBlock = 32;

/// Pairs [kPairsPerBlock * block, kPairsPerBlock * (block + 1)) of a family; they depend on nothing but the arguments.
std::vector<StressPair> stressBlock(std::size_t family, unsigned seed, std::int64_t block);

}  // namespace proximity_server::narrowphase
