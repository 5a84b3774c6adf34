#include "scene/bounds/leaf_boxes.h"

#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proximity_server::scene {
namespace {

/// The volumes that are the most levels below a root, if there are at most kMostLeaves.
std::vector<int> partsBelow(const std::vector<Volume>& volumes, int root) {
  std::vector<int> parts{root}, next;
  while (true) {
    next.clear();
    for (const int part : parts) {
      if (volumes[part].isLeaf())
        next.push_back(part);
      else
        next.insert(next.end(), volumes[part].parts.begin(), volumes[part].parts.end());
    }
    if (next.size() == parts.size() || next.size() > LeafBoxes::kMostLeaves) return parts;
    parts.swap(next);
  }
}

}  // namespace

LeafBoxes::LeafBoxes(const std::vector<Volume>& volumes, std::vector<int> leaves) : leaves_(std::move(leaves)) {
  values_.assign(lanes::kLeafRows * leaves_.size() + lanes::kMostLanes, 0.0f);
  Eigen::AlignedBox3d whole;
  for (const int leaf : leaves_) {
    const Bounds& bounds = volumes[leaf].bounds;
    const Eigen::Vector3d half = bounds.axes.cwiseAbs() * bounds.half;
    whole.extend(Eigen::AlignedBox3d(bounds.centre - half, bounds.centre + half));
  }
  centre_ = whole.center();
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    const Bounds& bounds = volumes[leaves_[i]].bounds;
    const auto row = [&](int number) -> float& { return values_[number * leaves_.size() + i]; };
    const Eigen::Vector3d centre = bounds.centre - centre_;
    for (int k = 0; k < 3; ++k) {
      row(lanes::kLeafCentre + k) = static_cast<float>(centre[k]);
      row(lanes::kLeafHalf + k) = roundedUp(bounds.half[k]);
    }
    for (int k = 0; k < 9; ++k) row(lanes::kLeafAxes + k) = static_cast<float>(bounds.axes(k / 3, k % 3));
    row(lanes::kLeafRadius) = roundedUp(bounds.radius);
    reach_ = std::max(reach_, centre.norm() + std::max(bounds.radius, bounds.half.norm()));
  }
  for (int k = 0; k < 3; ++k) {
    low_[k] = roundedDown(whole.min()[k] - centre_[k]);
    high_[k] = roundedUp(whole.max()[k] - centre_[k]);
  }
}

WideVolume::WideVolume(const std::vector<Volume>& volumes, int volume, const std::vector<int>& parts)
    : has_leaves_(std::all_of(parts.begin(), parts.end(), [&](int part) { return volumes[part].isLeaf(); })) {
  boxes_.reserve(volumes[volume].isLeaf() ? 1 : 2);
  boxes_.emplace_back(volumes, std::vector<int>{volume});
  if (!volumes[volume].isLeaf()) boxes_.emplace_back(volumes, parts);
}

void addWideVolumes(std::vector<Volume>& volumes, int root, std::vector<WideVolume>& wide) {
  if (volumes[root].isEmpty()) return;
  const std::vector<int> parts = partsBelow(volumes, root);
  volumes[root].wide = static_cast<int>(wide.size());
  wide.emplace_back(volumes, root, parts);
  if (wide.back().hasLeaves()) return;
  for (const int part : parts) addWideVolumes(volumes, part, wide);
}

LeafGaps::LeafGaps(const lanes::Kernels& kernels)
    : kernels_(kernels), found_(LeafBoxes::kMostLeaves * LeafBoxes::kMostLeaves) {
  gaps_.reserve(found_.size());
}

const std::vector<LeafGaps::Gap>& LeafGaps::between(const LeafBoxes& a, const LeafBoxes& b, const RelativePose& a_T_b,
                                                    double padding, double limit) {
  const Eigen::Vector3d moved_centre = a_T_b.rotation * b.centre();
  const Eigen::Vector3d offset = a_T_b.translation + moved_centre - a.centre();
  const double rounding = kPoseRounding * (a_T_b.translation.norm() + a.centre().norm() + moved_centre.norm());
  const double less = kError * (offset.norm() + a.reach() + b.reach()) + rounding + padding;
  float pose[lanes::kPoseRows];
  for (int k = 0; k < 9; ++k) pose[k] = static_cast<float>(a_T_b.rotation(k / 3, k % 3));
  for (int k = 0; k < 3; ++k) pose[9 + k] = static_cast<float>(offset[k]);
  const auto found = kernels_.leafGaps(a.lanes(), b.lanes(), pose, roundedUp(limit + less), found_.data());
  const int count_b = b.lanes().count;
  gaps_.clear();
  for (int i = 0; i < found.count; ++i) {
    const lanes::LeafGap& gap = found_[i];
    gaps_.push_back(
        {static_cast<double>(gap.lower_bound) - less, gap.a * count_b + gap.b, a.leaves()[gap.a], b.leaves()[gap.b]});
  }
  // Pairs that are left out are beyond the limit; but the difference may be rounded to the limit.
  smallest_of_others_ =
      std::max(static_cast<double>(found.smallest_of_others) - less, std::nextafter(limit, kInfinity));
  return gaps_;
}

}  // namespace proximity_server::scene
