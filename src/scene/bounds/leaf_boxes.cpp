#define PROXIMITY_LANES 4
#include "scene/bounds/leaf_boxes.h"

#include "scene/bounds/lane_vectors.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace proximity_server::scene {
namespace {

using lanes::all;
using lanes::dot;
using lanes::Int;
using lanes::kLanes;
using lanes::larger;
using lanes::Point;
using Lanes = LeafBoxes::Lanes;
using Pack = LeafBoxes::Pack;
static_assert(std::is_same_v<Lanes, lanes::Float>);

constexpr std::size_t packsFor(std::size_t leaves) { return (leaves + kLanes - 1) / kLanes; }

Point centreOf(const Pack& pack) { return {pack.centre[0], pack.centre[1], pack.centre[2]}; }
Point axisOf(const Pack& pack, int k) { return {pack.axes[k], pack.axes[3 + k], pack.axes[6 + k]}; }

void collect(const std::vector<Volume>& volumes, int volume, std::vector<int>& leaves) {
  const Volume& here = volumes[volume];
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

/// A pack with one leaf in all lanes.
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
    const Point turn{all(static_cast<float>(a_T_b.rotation(row, 0))), all(static_cast<float>(a_T_b.rotation(row, 1))),
                     all(static_cast<float>(a_T_b.rotation(row, 2)))};
    in_a.centre[row] = dot(centreOf(b), turn) + static_cast<float>(a_T_b.translation[row]);
    for (int column = 0; column < 3; ++column) in_a.axes[3 * row + column] = dot(axisOf(b, column), turn);
  }
  return in_a;
}

/// Like boxGap() in bounds.h. `offset` is the vector from the centre of a to that of b, in their common frame, and
/// `distance` is its length.
Lanes boxGap(const Pack& a, const Pack& b, const Point& offset, Lanes distance) {
  Lanes cosines[9], offset_in_a[3], offset_in_b[3], along_offset = all(0.0f);
  for (int k = 0; k < 3; ++k) {
    offset_in_a[k] = dot(offset, axisOf(a, k));
    offset_in_b[k] = dot(offset, axisOf(b, k));
    for (int j = 0; j < 3; ++j) cosines[3 * k + j] = dot(axisOf(b, j), axisOf(a, k));
  }
  for (int k = 0; k < 3; ++k) along_offset += lanes::absolute(offset_in_a[k]) * a.half[k];
  for (int k = 0; k < 3; ++k) along_offset += lanes::absolute(offset_in_b[k]) * b.half[k];
  const Lanes gap = lanes::boxGap(cosines, offset_in_a, offset_in_b, a.half, b.half, 0.0f);
  return larger(distance > all(1e-12f) ? distance - along_offset / distance : gap, gap);
}

}  // namespace

LeafBoxes::LeafBoxes(const std::vector<Volume>& volumes, int root) {
  collect(volumes, root, leaves_);
  if (static_cast<int>(leaves_.size()) > kMostLeaves) leaves_.clear();
  packs_.resize(packsFor(leaves_.size()));
  for (std::size_t i = 0; i < kLanes * packs_.size(); ++i) {
    const int leaf = leaves_[std::min(i, leaves_.size() - 1)];
    const Bounds& bounds = volumes[leaf].bounds;
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
      const Point offset = centreOf(pack) - centreOf(leaf);
      const Lanes distance = lanes::root(dot(offset, offset));
      Lanes gap = distance - (leaf.radius + pack.radius);
      if (lanes::any(~(gap > far))) gap = larger(gap, boxGap(leaf, pack, offset, distance));
      others = lanes::smaller(others, gap > far ? gap : others);
      const Int is_near = ~(gap > far);
      if (!lanes::any(is_near)) continue;
      for (std::size_t lane = 0; lane < kLanes && kLanes * j + lane < b.leaves().size(); ++lane)
        if (const auto k = static_cast<int>(lane); is_near[k])
          gaps_.push_back({static_cast<double>(gap[k]) - less, a.leaves()[i], b.leaves()[kLanes * j + lane]});
    }
  }
  smallest_of_others_ = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kLanes; ++k)
    smallest_of_others_ = std::min(smallest_of_others_, static_cast<double>(others[k]) - less);
  // Pairs that are left out are beyond the limit; but the difference above may be rounded to the limit.
  smallest_of_others_ = std::max(smallest_of_others_, std::nextafter(limit, std::numeric_limits<double>::infinity()));
  return gaps_;
}

}  // namespace proximity_server::scene
