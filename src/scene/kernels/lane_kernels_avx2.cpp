#define PROXIMITY_LANES 8
#include "scene/kernels/leaf_code.h"

namespace proximity_server::scene::lanes {

const Kernels& avx2Kernels() {
  static const Kernels kernels{"avx2",   sinesAndCosines, placeBodiesAndLinks, travel,
                               markNear, findNear,        relativePoses,       boundByOutlines,
                               boxGaps,  boundByGjk,      boundByInnerBalls,   leafGaps};
  return kernels;
}

}  // namespace proximity_server::scene::lanes
