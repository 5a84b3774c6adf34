// Vectors of PROXIMITY_LANES floats, and the gap of boxes in each lane. This file is included by sources that are
// compiled for one kind of processor. Everything is local to them, so that the linker cannot keep a copy that older
// processors cannot run.
//
// No product is fused with a sum (-ffp-contract=off), and the order of sums is fixed: so the bits do not depend on the
// number of lanes.
// The vectors are built into the compiler (GCC, clang), and not from a library. They need only operators here, their
// code is the same as with xsimd (vmaxps, vblendmps), and they define no inline function in sources with other
// options.

namespace proximity_server::scene::lanes {
namespace {

constexpr int kLanes = PROXIMITY_LANES;
using Float = float __attribute__((vector_size(4 * kLanes)));
using Int = int __attribute__((vector_size(4 * kLanes)));

Float all(float value) { return value - Float{}; }  // unlike a sum with 0.0f, this is no operation
Float larger(Float a, Float b) { return a > b ? a : b; }
Float smaller(Float a, Float b) { return a < b ? a : b; }
Float absolute(Float a) { return reinterpret_cast<Float>(reinterpret_cast<Int>(a) & 0x7fffffff); }
Float root(Float a) {
  Float result;
  for (int i = 0; i < kLanes; ++i) result[i] = __builtin_sqrtf(a[i]);
  return result;
}

/// Bit i is set if lane i is true.
[[maybe_unused]] unsigned bits(Int mask) {
#if defined(__x86_64__) && PROXIMITY_LANES == 4
  return static_cast<unsigned>(__builtin_ia32_movmskps(reinterpret_cast<Float>(mask)));
#elif defined(__AVX2__) && PROXIMITY_LANES == 8
  return static_cast<unsigned>(__builtin_ia32_movmskps256(reinterpret_cast<Float>(mask)));
#elif defined(__AVX512F__) && PROXIMITY_LANES == 16
  constexpr int kIsNotEqual = 4;
  return __builtin_ia32_cmpd512_mask(mask, Int{}, kIsNotEqual, 0xffff);
#else
  unsigned found = 0;
  for (int i = 0; i < kLanes; ++i) found |= (mask[i] ? 1u : 0u) << i;
  return found;
#endif
}
[[maybe_unused]] bool any(Int mask) { return bits(mask) != 0; }

struct Point {
  Float x, y, z;
};
[[maybe_unused]] Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
[[maybe_unused]] Float dot(const Point& a, const Point& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

/// A lower bound of the distance of a point from a box about the origin; negative inside.
Float fromBox(const Float* gaps) {
  Float largest = larger(larger(gaps[0], gaps[1]), gaps[2]), sum = all(0.0f);
  for (int k = 0; k < 3; ++k) {
    const Float positive = larger(gaps[k], all(0.0f));
    sum = sum + positive * positive;
  }
  return largest > all(0.0f) ? root(sum) : largest;
}

/// The larger one of two distances: of box a from the bounding box of b along the axes of a, and of box b from the
/// bounding box of a along the axes of b; negative in overlap. The axes k of a and j of b have the cosine 3 k + j.
/// `offset_in_a` and `offset_in_b` are the vector between the centres along the axes of a and of b. `error` is
/// subtracted from each gap along an axis.
template <typename HalfA, typename HalfB>
[[gnu::always_inline]] inline Float boxGap(const Float* cosines, const Float* offset_in_a, const Float* offset_in_b,
                                           const HalfA* half_a, const HalfB* half_b, float error) {
  Float gaps_a[3], gaps_b[3];
  for (int k = 0; k < 3; ++k) {
    Float width_b = all(0.0f), width_a = all(0.0f);
    for (int j = 0; j < 3; ++j) {
      width_b = width_b + absolute(cosines[3 * k + j]) * half_b[j];
      width_a = width_a + absolute(cosines[3 * j + k]) * half_a[j];
    }
    gaps_a[k] = ((absolute(offset_in_a[k]) - half_a[k]) - width_b) - error;
    gaps_b[k] = ((absolute(offset_in_b[k]) - half_b[k]) - width_a) - error;
  }
  return larger(fromBox(gaps_a), fromBox(gaps_b));
}

}  // namespace
}  // namespace proximity_server::scene::lanes
