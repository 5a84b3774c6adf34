#include "scene/query/leaf_boxes.h"

#include <algorithm>
#include <cmath>

#include "scene/model/rounded.h"

namespace proximity_server::scene {
namespace {

constexpr int kLanes = LeafBoxes::kLanes;
using Lanes = LeafBoxes::Lanes;
using Pack = LeafBoxes::Pack;
using Mask = int __attribute__((vector_size(4 * kLanes)));

constexpr std::size_t packsFor(std::size_t leaves) { return (leaves + kLanes - 1) / kLanes; }

// Some of these stand in batch/lane_code.h too, which can share no function with sources of other compiler options.
Lanes all(float value) { return Lanes{} + value; }
Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
Lanes smaller(Lanes a, Lanes b) { return a < b ? a : b; }
Lanes absolute(Lanes a) { return reinterpret_cast<Lanes>(reinterpret_cast<Mask>(a) & 0x7fffffff); }
Lanes root(Lanes a) {
  Lanes result;
  for (int i = 0; i < kLanes; ++i) result[i] = __builtin_sqrtf(a[i]);
  return result;
}
bool any(Mask mask) {
  int found = 0;
  for (int i = 0; i < kLanes; ++i) found |= mask[i];
  return found != 0;
}
Lanes dot(Lanes x, Lanes y, Lanes z, const Lanes* other) { return (x * other[0] + y * other[1]) + z * other[2]; }

void collect(const std::vector<Volume>& volumes, int volume, std::vector<int>& leaves) {
  const Volume& here = volumes[static_cast<std::size_t>(volume)];
  if (here.isEmpty() || static_cast<int>(leaves.size()) > LeafBoxes::kMostLeaves) return;
  if (here.isLeaf())
    leaves.push_back(volume);
  else
    for (const int part : here.parts) collect(volumes, part, leaves);
}

void setLane(const Bounds& bounds, int lane, Pack& pack) {
  for (int k = 0; k < 3; ++k) {
    pack.centre[k][lane] = static_cast<float>(bounds.centre[k]);
    pack.half[k][lane] = roundedUp(bounds.half[k]);
  }
  for (int k = 0; k < 9; ++k) pack.axes[k][lane] = static_cast<float>(bounds.axes(k / 3, k % 3));
  pack.radius[lane] = roundedUp(bounds.radius);
}

/// One leaf in all lanes.
Pack spread(const Pack& pack, int lane) {
  Pack leaf;
  for (int k = 0; k < 3; ++k) {
    leaf.centre[k] = all(pack.centre[k][lane]);
    leaf.half[k] = all(pack.half[k][lane]);
  }
  for (int k = 0; k < 9; ++k) leaf.axes[k] = all(pack.axes[k][lane]);
  leaf.radius = all(pack.radius[lane]);
  return leaf;
}

Pack placed(const Pack& b, const RelativePose& a_T_b) {
  Pack in_a = b;
  for (int row = 0; row < 3; ++row) {
    const Lanes turn[3] = {all(static_cast<float>(a_T_b.rotation(row, 0))),
                           all(static_cast<float>(a_T_b.rotation(row, 1))),
                           all(static_cast<float>(a_T_b.rotation(row, 2)))};
    in_a.centre[row] = dot(b.centre[0], b.centre[1], b.centre[2], turn) + static_cast<float>(a_T_b.translation[row]);
    for (int column = 0; column < 3; ++column)
      in_a.axes[3 * row + column] = dot(b.axes[column], b.axes[3 + column], b.axes[6 + column], turn);
  }
  return in_a;
}

/// The distance of a point from a box about the origin, less than 0 inside.
Lanes fromBox(const Lanes* gaps) {
  const Lanes largest = larger(larger(gaps[0], gaps[1]), gaps[2]), zero = all(0.0f);
  Lanes sum = zero;
  for (int k = 0; k < 3; ++k) {
    const Lanes positive = larger(gaps[k], zero);
    sum += positive * positive;
  }
  return largest > zero ? root(sum) : largest;
}

/// As boxGap() in bounds.h. `way` leads from the centre of a to that of b, in their common frame, and is `distance` long.
Lanes boxGap(const Pack& a, const Pack& b, const Lanes* way, Lanes distance) {
  Lanes gaps_a[3], gaps_b[3], widths_a[3] = {}, along_way = all(0.0f);
  for (int k = 0; k < 3; ++k) {
    const Lanes axis[3] = {a.axes[k], a.axes[3 + k], a.axes[6 + k]};
    Lanes width_b = all(0.0f);
    for (int j = 0; j < 3; ++j) {
      const Lanes cosine = absolute(dot(b.axes[j], b.axes[3 + j], b.axes[6 + j], axis));
      width_b += cosine * b.half[j];
      widths_a[j] += cosine * a.half[k];
    }
    const Lanes in_a = absolute(dot(way[0], way[1], way[2], axis));
    gaps_a[k] = (in_a - a.half[k]) - width_b;
    along_way += in_a * a.half[k];
  }
  for (int j = 0; j < 3; ++j) {
    const Lanes in_b = absolute(dot(b.axes[j], b.axes[3 + j], b.axes[6 + j], way));
    gaps_b[j] = (in_b - b.half[j]) - widths_a[j];
    along_way += in_b * b.half[j];
  }
  const Lanes from_a = fromBox(gaps_a);
  const Lanes along = distance > all(1e-12f) ? distance - along_way / distance : from_a;
  return larger(along, larger(from_a, fromBox(gaps_b)));
}

}  // namespace

LeafBoxes::LeafBoxes(const std::vector<Volume>& volumes, int root) {
  collect(volumes, root, leaves_);
  if (static_cast<int>(leaves_.size()) > kMostLeaves) leaves_.clear();
  packs_.resize(packsFor(leaves_.size()));
  for (std::size_t i = 0; i < kLanes * packs_.size(); ++i) {
    const int leaf = leaves_[std::min(i, leaves_.size() - 1)];
    const Bounds& bounds = volumes[static_cast<std::size_t>(leaf)].bounds;
    setLane(bounds, static_cast<int>(i % kLanes), packs_[i / kLanes]);
    reach_ = std::max(reach_, bounds.centre.norm() + std::max(bounds.radius, bounds.half.norm()));
  }
}

LeafGaps::LeafGaps() : b_(packsFor(LeafBoxes::kMostLeaves)) {
  gaps_.reserve(LeafBoxes::kMostLeaves * LeafBoxes::kMostLeaves);
}

const std::vector<LeafGaps::Gap>& LeafGaps::between(const LeafBoxes& a, const LeafBoxes& b, const RelativePose& a_T_b,
                                                    double padding, double limit) {
  const double less = kError * reachOf(a, b, a_T_b) + padding;
  const Lanes far = all(roundedUp(limit + less));
  Lanes others = all(std::numeric_limits<float>::infinity());
  gaps_.clear();
  for (std::size_t j = 0; j < b.packs().size(); ++j) b_[j] = placed(b.packs()[j], a_T_b);
  for (std::size_t i = 0; i < a.leaves().size(); ++i) {
    const Pack leaf = spread(a.packs()[i / kLanes], static_cast<int>(i % kLanes));
    for (std::size_t j = 0; j < b.packs().size(); ++j) {
      const Pack& pack = b_[j];
      const Lanes way[3] = {pack.centre[0] - leaf.centre[0], pack.centre[1] - leaf.centre[1],
                            pack.centre[2] - leaf.centre[2]};
      const Lanes distance = root(dot(way[0], way[1], way[2], way));
      Lanes gap = distance - (leaf.radius + pack.radius);
      if (any(~(gap > far))) gap = larger(gap, boxGap(leaf, pack, way, distance));
      others = smaller(others, gap > far ? gap : others);
      const Mask is_near = ~(gap > far);
      if (!any(is_near)) continue;
      for (std::size_t lane = 0; lane < kLanes && kLanes * j + lane < b.leaves().size(); ++lane)
        if (const auto k = static_cast<int>(lane); is_near[k])
          gaps_.push_back({static_cast<double>(gap[k]) - less, a.leaves()[i], b.leaves()[kLanes * j + lane]});
    }
  }
  smallest_of_others_ = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kLanes; ++k)
    smallest_of_others_ = std::min(smallest_of_others_, static_cast<double>(others[k]) - less);
  // What is left out is beyond the limit; the difference above may be rounded to it.
  smallest_of_others_ = std::max(smallest_of_others_, std::nextafter(limit, std::numeric_limits<double>::infinity()));
  return gaps_;
}

}  // namespace proximity_server::scene
