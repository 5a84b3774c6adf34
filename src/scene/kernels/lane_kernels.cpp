#include "scene/kernels/lane_kernels.h"

namespace proximity_server::scene::lanes {
namespace {

struct Available {
  const Kernels* list[4] = {};

  Available() {
    int count = 0;
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512f")) list[count++] = &avx512Kernels();
    if (__builtin_cpu_supports("avx2")) list[count++] = &avx2Kernels();
#endif
    list[count] = &baselineKernels();
  }
};

}  // namespace

const Kernels* const* allKernels() {
  static const Available available;
  return available.list;
}

const Kernels& kernels() { return **allKernels(); }

}  // namespace proximity_server::scene::lanes
