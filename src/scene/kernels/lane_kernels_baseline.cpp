#define PROXIMITY_LANES 4
#include "scene/kernels/leaf_code.h"

namespace proximity_server::scene::lanes {

const Kernels& baselineKernels() {
  static const Kernels kernels{"baseline", sinesAndCosines, placeBodiesAndLinks, travel,
                               markNear,   findNear,        relativePoses,       boundByOutlines,
                               boxGaps,    boundByGjk,      boundByInnerBalls,   leafGaps};
  return kernels;
}

}  // namespace proximity_server::scene::lanes
