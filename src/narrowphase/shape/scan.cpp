#include "narrowphase/shape/scan.h"

#include <atomic>
#include <cstdint>
#include <cstring>

namespace proximity_server::narrowphase {
namespace {

using ScanFunction = int (*)(const double*, const double*, const double*, int, const double*);

typedef double Values16 __attribute__((vector_size(16)));
typedef double Values32 __attribute__((vector_size(32)));
typedef double Values64 __attribute__((vector_size(64)));
typedef std::int64_t Indices16 __attribute__((vector_size(16)));
typedef std::int64_t Indices32 __attribute__((vector_size(32)));
typedef std::int64_t Indices64 __attribute__((vector_size(64)));

/// The scan with vectors of one width. Every lane keeps its own maximum; two vectors at a time hide the latency.
template <typename Values, typename Indices>
struct Lanes {
  static constexpr int kWidth = sizeof(Values) / sizeof(double);

  struct Best {
    Values height;
    Indices index;
  };

  [[gnu::always_inline]] static inline void load(const double* from, Values& to) { std::memcpy(&to, from, sizeof to); }

  [[gnu::always_inline]] static inline void heights(const double* x, const double* y, const double* z, const double* d,
                                                    Values& to) {
    Values px, py, pz;
    load(x, px);
    load(y, py);
    load(z, pz);
    to = d[0] * px + d[1] * py + d[2] * pz;
  }

  [[gnu::always_inline]] static inline void offer(Best& best, const Values& height, const Indices& index) {
    const Indices higher = height > best.height;
    best.height = higher ? height : best.height;
    best.index = higher ? index : best.index;
  }

  [[gnu::always_inline]] static inline int scan(const double* x, const double* y, const double* z, int count,
                                                const double* d) {
    std::int64_t lanes[kWidth];
    for (int lane = 0; lane < kWidth; ++lane) lanes[lane] = lane;
    Best even, odd;
    std::memcpy(&even.index, lanes, sizeof lanes);
    odd.index = even.index + kWidth;
    heights(x, y, z, d, even.height);
    heights(x + kWidth, y + kWidth, z + kWidth, d, odd.height);
    Indices even_index = even.index, odd_index = odd.index;
    for (int i = 2 * kWidth; i < count; i += 2 * kWidth) {
      Values height;
      even_index += 2 * kWidth;
      odd_index += 2 * kWidth;
      heights(x + i, y + i, z + i, d, height);
      offer(even, height, even_index);
      heights(x + i + kWidth, y + i + kWidth, z + i + kWidth, d, height);
      offer(odd, height, odd_index);
    }
    return first(even, odd);
  }

  /// The smallest of the indices with the greatest height. There are no branches, as they could not be predicted.
  [[gnu::always_inline]] static inline int first(const Best& even, const Best& odd) {
    const Indices is_odd = (odd.height > even.height) | ((odd.height == even.height) & (odd.index < even.index));
    const Values heights = is_odd ? odd.height : even.height;
    const Indices indices = is_odd ? odd.index : even.index;
    double height[kWidth];
    std::int64_t index[kWidth];
    std::memcpy(height, &heights, sizeof heights);
    std::memcpy(index, &indices, sizeof indices);
    for (int lanes = kWidth / 2; lanes > 0; lanes /= 2)
      for (int i = 0; i < lanes; ++i) {
        const bool is_higher = height[i + lanes] > height[i], is_first = index[i + lanes] < index[i];
        const bool is_better = is_higher | ((height[i + lanes] == height[i]) & is_first);
        height[i] = is_better ? height[i + lanes] : height[i];
        index[i] = is_better ? index[i + lanes] : index[i];
      }
    return static_cast<int>(index[0]);
  }
};

int scanBaseline(const double* x, const double* y, const double* z, int count, const double* d) {
  return Lanes<Values16, Indices16>::scan(x, y, z, count, d);
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] int scanAvx2(const double* x, const double* y, const double* z, int count, const double* d) {
  return Lanes<Values32, Indices32>::scan(x, y, z, count, d);
}

[[gnu::target("avx512f")]] int scanAvx512(const double* x, const double* y, const double* z, int count,
                                          const double* d) {
  return Lanes<Values64, Indices64>::scan(x, y, z, count, d);
}

bool hasAvx2() {
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx2");
}

bool hasAvx512() {
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx512f");
}

ScanFunction widest() { return hasAvx512() ? scanAvx512 : hasAvx2() ? scanAvx2 : scanBaseline; }
#else
ScanFunction widest() { return scanBaseline; }
#endif

int scanFirst(const double* x, const double* y, const double* z, int count, const double* d);

/// The scan for this processor. The first call sets it; later calls need no lock.
std::atomic<ScanFunction> chosen{scanFirst};

int scanFirst(const double* x, const double* y, const double* z, int count, const double* d) {
  chosen.store(widest(), std::memory_order_relaxed);
  return scan(x, y, z, count, Eigen::Vector3d(d));
}

}  // namespace

int scan(const double* x, const double* y, const double* z, int count, const Eigen::Vector3d& direction) {
  return chosen.load(std::memory_order_relaxed)(x, y, z, count, direction.data());
}

std::vector<ScanOfWidth> availableScans() {
  std::vector<ScanOfWidth> scans{{Lanes<Values16, Indices16>::kWidth, scanBaseline}};
#if defined(__x86_64__)
  if (hasAvx2()) scans.push_back({Lanes<Values32, Indices32>::kWidth, scanAvx2});
  if (hasAvx512()) scans.push_back({Lanes<Values64, Indices64>::kWidth, scanAvx512});
#endif
  return scans;
}

}  // namespace proximity_server::narrowphase
