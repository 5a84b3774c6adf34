// Bounds of the distances of all pairs of leaves of two parts, see Kernels::leafGaps.
//
// 1. Exclude the leaves of each part whose spheres are far from the bounding box of the other part.
// 2. Bound the pairs of the others by their spheres, then by their boxes. One leaf of one part is in all lanes, and the
//    leaves of the other part are side by side.
//
// Few links fill 16 lanes: with them PR2 takes as long as with 8, and UR5 a third longer (AMD EPYC, 2026-11).

#include "scene/kernels/lane_code.h"

namespace proximity_server::scene::lanes {
namespace {

Float loadAnywhere(const float* row) {
  Float value;
  __builtin_memcpy(&value, row, sizeof value);
  return value;
}
Int laneNumbers() {
  Int numbers;
  for (int k = 0; k < kLanes; ++k) numbers[k] = k;
  return numbers;
}

/// Leaves side by side, one in each lane. `columns` are their columns among all leaves.
struct ManyLeaves {
  const Leaves& leaves;
  int first;
  const int* columns = nullptr;
  Float operator[](int row) const { return loadAnywhere(leaves.values + row * leaves.stride + first); }
  int column(int lane) const { return columns[first + lane]; }
};

/// One leaf in all lanes.
struct OneLeaf {
  const Leaves& leaves;
  int place;
  Float operator[](int row) const { return all(leaves.values[row * leaves.stride + place]); }
  int column(int) const { return place; }
};

template <typename Leaf>
Point leafCentre(const Leaf& leaf) {
  return {leaf[kLeafCentre], leaf[kLeafCentre + 1], leaf[kLeafCentre + 2]};
}
template <typename Leaf>
Point leafAxis(const Leaf& leaf, int k) {
  return {leaf[kLeafAxes + k], leaf[kLeafAxes + 3 + k], leaf[kLeafAxes + 6 + k]};
}

/// Like boxGap() in bounds.h. `offset` is the vector from the centre of a to the centre of b, in their common frame,
/// and `distance` is its length.
template <typename A, typename B>
Float leafBoxGap(const A& a, const B& b, const Point& offset, Float distance) {
  Float cosines[9], offset_in_a[3], offset_in_b[3], half_a[3], half_b[3], along_offset = all(0.0f);
  for (int k = 0; k < 3; ++k) {
    half_a[k] = a[kLeafHalf + k];
    half_b[k] = b[kLeafHalf + k];
    offset_in_a[k] = dot(offset, leafAxis(a, k));
    offset_in_b[k] = dot(offset, leafAxis(b, k));
    for (int j = 0; j < 3; ++j) cosines[3 * k + j] = dot(leafAxis(b, j), leafAxis(a, k));
  }
  for (int k = 0; k < 3; ++k) along_offset = along_offset + absolute(offset_in_a[k]) * half_a[k];
  for (int k = 0; k < 3; ++k) along_offset = along_offset + absolute(offset_in_b[k]) * half_b[k];
  const Float gap = boxGap(cosines, offset_in_a, offset_in_b, half_a, half_b, 0.0f);
  return larger(distance > all(1e-12f) ? distance - along_offset / distance : gap, gap);
}

/// Room for leaves that are moved or packed.
struct LeafValues {
  static constexpr int kStride = kMostLeaves + kMostLanes;
  alignas(64) float rows[kLeafRows][kStride];
  Leaves leaves(int count) const { return {count, kStride, rows[0], {}, {}}; }
};

/// Moves leaves from frame b into frame a.
Leaves placed(const Leaves& leaves, const Pose& a_T_b, LeafValues& values) {
  for (int first = 0; first < leaves.count; first += kLanes) {
    const ManyLeaves leaf{leaves, first};
    const auto set = [&](int row, int step, const Point& p) {
      store(p.x, values.rows[row] + first);
      store(p.y, values.rows[row + step] + first);
      store(p.z, values.rows[row + 2 * step] + first);
    };
    set(kLeafCentre, 1, a_T_b.origin + turned(a_T_b.rotation, leafCentre(leaf)));
    set(kLeafHalf, 1, {leaf[kLeafHalf], leaf[kLeafHalf + 1], leaf[kLeafHalf + 2]});
    for (int k = 0; k < 3; ++k) set(kLeafAxes + k, 3, turned(a_T_b.rotation, leafAxis(leaf, k)));
    store(leaf[kLeafRadius], values.rows[kLeafRadius] + first);
  }
  return values.leaves(leaves.count);
}

/// Some of the leaves of a part.
struct LeafList {
  int count = 0;
  int columns[kMostLeaves];
  void add(int column) { columns[count++] = column; }
};

/// Puts the listed leaves side by side.
Leaves packed(const Leaves& leaves, const LeafList& list, LeafValues& values) {
  if (list.count == leaves.count) return leaves;
  for (int row = 0; row < kLeafRows; ++row)
    for (int i = 0; i < list.count; ++i) values.rows[row][i] = leaves.values[row * leaves.stride + list.columns[i]];
  return values.leaves(list.count);
}

/// Sorts out what is above the limit, and writes the other pairs.
struct LeafSearch {
  const Float limit;
  Float others;  ///< the smallest bound above the limit
  LeafGap* const gaps;
  int found = 0;

  /// The lanes whose bound is not above the limit. Only the first `count` lanes have one.
  unsigned near(Float gap, int count) {
    const Int is_given = laneNumbers() < count;
    const Int is_far = gap > limit;
    others = is_given & is_far ? smaller(others, gap) : others;
    return bits(is_given & ~is_far);
  }

  /// Lists the leaves whose spheres may be near the bounding box of another part. `in_other` places points in the frame
  /// of that part.
  template <typename Placing>
  void addNear(const Leaves& other, const Leaves& leaves, const Placing& in_other, LeafList& list) {
    for (int first = 0; first < leaves.count; first += kLanes) {
      const ManyLeaves leaf{leaves, first};
      const Point p = in_other(leafCentre(leaf));
      const Float along[3] = {larger(other.low[0] - p.x, p.x - other.high[0]),
                              larger(other.low[1] - p.y, p.y - other.high[1]),
                              larger(other.low[2] - p.z, p.z - other.high[2])};
      const Float gap = fromBox(along) - leaf[kLeafRadius];
      for (unsigned lanes = near(gap, leaves.count - first); lanes != 0; lanes &= lanes - 1)
        list.add(first + __builtin_ctz(lanes));
    }
  }

  /// Bounds `count` pairs of leaves.
  template <typename A, typename B>
  void bound(const A& a, const B& b, int count) {
    const Point offset = leafCentre(b) - leafCentre(a);
    const Float distance = root(dot(offset, offset));
    const Float spheres = distance - (a[kLeafRadius] + b[kLeafRadius]);
    if (near(spheres, count) == 0) return;
    // Boxes do not count where spheres are enough, so that no bound depends on the other lanes.
    const Float gap = spheres > limit ? spheres : larger(spheres, leafBoxGap(a, b, offset, distance));
    for (unsigned lanes = near(gap, count); lanes != 0; lanes &= lanes - 1) {
      const int lane = __builtin_ctz(lanes);
      gaps[found++] = {gap[lane], a.column(lane), b.column(lane)};
    }
  }

  /// Bounds the pairs of the listed leaves, which are in one frame. The leaves of the part that fills more lanes are
  /// side by side.
  void boundAll(const Leaves& a, const LeafList& list_a, const Leaves& b, const LeafList& list_b) {
    const auto packs = [](const LeafList& list) { return (list.count + kLanes - 1) / kLanes; };
    LeafValues values;
    if (list_a.count * packs(list_b) <= list_b.count * packs(list_a)) {
      const Leaves many = packed(b, list_b, values);
      for (int i = 0; i < list_a.count; ++i)
        for (int j = 0; j < list_b.count; j += kLanes)
          bound(OneLeaf{a, list_a.columns[i]}, ManyLeaves{many, j, list_b.columns}, list_b.count - j);
    } else {
      const Leaves many = packed(a, list_a, values);
      for (int j = 0; j < list_b.count; ++j)
        for (int i = 0; i < list_a.count; i += kLanes)
          bound(ManyLeaves{many, i, list_a.columns}, OneLeaf{b, list_b.columns[j]}, list_a.count - i);
    }
  }

  FoundLeafGaps result() const {
    float smallest = __builtin_inff();
    for (int k = 0; k < kLanes; ++k) smallest = others[k] < smallest ? others[k] : smallest;
    return {found, smallest};
  }
};

FoundLeafGaps leafGaps(const Leaves& a, const Leaves& b, const float* numbers, float limit, LeafGap* gaps) {
  constexpr int kFewPairs = 16;  // fewer are bounded as quickly as they are excluded
  LeafSearch search{all(limit), all(__builtin_inff()), gaps};
  Pose a_T_b;
  for (int k = 0; k < 9; ++k) a_T_b.rotation[k] = all(numbers[k]);
  a_T_b.origin = point(numbers + 9);
  LeafList list_a, list_b;
  if (a.count * b.count <= kFewPairs) {
    for (int i = 0; i < a.count; ++i) list_a.add(i);
    for (int j = 0; j < b.count; ++j) list_b.add(j);
  } else {
    const auto in_a = [&](const Point& p) { return a_T_b.origin + turned(a_T_b.rotation, p); };
    const auto in_b = [&](const Point& p) { return turnedBack(a_T_b.rotation, p - a_T_b.origin); };
    search.addNear(b, a, in_b, list_a);
    if (list_a.count == 0) return search.result();
    search.addNear(a, b, in_a, list_b);
    if (list_b.count == 0) return search.result();
  }
  LeafValues values;
  search.boundAll(a, list_a, placed(b, a_T_b, values), list_b);
  return search.result();
}

}  // namespace
}  // namespace proximity_server::scene::lanes
