#define PROXIMITY_LANES 8
#include "scene/lanes/lane_code.h"

namespace proximity_server::scene::lanes {

const Kernels& avx2Kernels() {
  static const Kernels kernels{"avx2",   sinesAndCosines, placeBodiesAndLinks, travel,
                               markNear, findNear,        relativePoses,       boundByOutlines,
                               boxGaps,  boundByGjk,      boundByInnerBalls};
  return kernels;
}

}  // namespace proximity_server::scene::lanes
