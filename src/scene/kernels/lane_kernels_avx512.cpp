#define PROXIMITY_LANES 16
#include "scene/kernels/lane_code.h"

namespace proximity_server::scene::lanes {

const Kernels& avx512Kernels() {
  static const Kernels kernels{"avx512", sinesAndCosines, placeBodiesAndLinks, travel,
                               markNear, findNear,        relativePoses,       boundByOutlines,
                               boxGaps,  boundByGjk,      boundByInnerBalls,   avx2Kernels().leafGaps};
  return kernels;
}

}  // namespace proximity_server::scene::lanes
