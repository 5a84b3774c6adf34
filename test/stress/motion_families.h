#pragma once

#include "chance.h"
#include "oracle/motion_oracle.h"
#include "proximity_server/narrowphase/motion/motion.h"

#include <cstdint>
#include <vector>

namespace proximity_server::narrowphase {

/// One question about two moving shapes, complete.
struct StressMotion {
  Shape a;
  MotionChain a_motion;
  Shape b;
  MotionChain b_motion;
  ContactOptions options;
  std::vector<double> suspects;  ///< times at which the shapes are close, by construction

  MovingPair pair() const { return {a, a_motion, b, b_motion}; }
};

/// Motions that share one kind of trouble.
struct MotionFamily {
  const char* name;
  StressMotion (*motion)(Chance&);
  int rarity = 1;  ///< a slow family takes part in every so many rounds of a run only
};

const std::vector<MotionFamily>& motionFamilies();

/// Depends on nothing but the arguments.
StressMotion stressMotion(std::size_t family, unsigned seed, std::int64_t number);

}  // namespace proximity_server::narrowphase
