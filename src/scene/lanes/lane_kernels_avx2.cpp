#define PROXIMITY_LANES 8
#include "scene/lanes/lane_code.h"

namespace proximity_server::scene::lanes {

const Kernels& avx2Kernels() {
  static const Kernels kernels{"avx2", turn, place, far, relate, search, meet};
  return kernels;
}

}  // namespace proximity_server::scene::lanes
