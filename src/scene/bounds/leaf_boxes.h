#pragma once

#include "scene/bounds/bounds.h"
#include "scene/bounds/volume_tree.h"
#include "scene/kernels/lane_kernels.h"

#include <limits>
#include <vector>

namespace proximity_server::scene {

/// The spheres and boxes of some volumes of a body, see Bounds, in float and side by side. The volumes are called leaves,
/// as most of them are.
class LeafBoxes {
 public:
  /// The boxes of at most kMostLeaves of the volumes, by their numbers.
  LeafBoxes(const std::vector<Volume>& volumes, std::vector<int> leaves);
  static constexpr int kMostLeaves = lanes::kMostLeaves;

  const std::vector<int>& leaves() const { return leaves_; }  ///< the numbers of the volumes
  lanes::Leaves lanes() const {
    const int count = static_cast<int>(leaves_.size());
    return {count, count, values_.data(), {low_[0], low_[1], low_[2]}, {high_[0], high_[1], high_[2]}};
  }
  /// [m] in the frame of the body. The numbers in float are relative to it, so that they are exact enough far from the
  /// origin of the body, too.
  const Eigen::Vector3d& centre() const { return centre_; }
  /// [m] upper bound of the distance of any point of the boxes and spheres from the centre
  double reach() const { return reach_; }

 private:
  std::vector<int> leaves_;
  std::vector<float> values_;
  Eigen::Vector3d centre_;
  float low_[3] = {}, high_[3] = {};
  double reach_ = 0.0;
};

/// A volume whose parts are the volumes some levels below it, so that a search bounds all of them at once.
///
/// Source: Dammertz, Hanika, Keller, Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays,
///         2008.
class WideVolume {
 public:
  /// `parts`: all leaves of the volume; if they are too many, parts that are wide volumes again.
  WideVolume(const std::vector<Volume>& volumes, int volume, const std::vector<int>& parts);

  const LeafBoxes& whole() const { return boxes_.front(); }  ///< of the volume itself
  const LeafBoxes& parts() const { return boxes_.back(); }
  bool hasLeaves() const { return has_leaves_; }

 private:
  std::vector<LeafBoxes> boxes_;  ///< one list for both, if the volume is a leaf
  bool has_leaves_;
};

/// Appends the wide volumes of a hierarchy, and tells its volumes their numbers.
void addWideVolumes(std::vector<Volume>& volumes, int root, std::vector<WideVolume>& wide);

/// Lower bounds of the distances of all pairs of two lists of volumes, several at a time.
///
/// Bounds:  those of sphereGap() and boxGap(). Leaves whose spheres are far from the bounding box of the other list
///          are left out before.
/// Error:   let u be 2^-24. The error is 4 u of the lengths for each centre and 12 u for each cosine of two axes. So it
///          is 40 u for the width of a box along an axis and 64 u for a gap, and at most 1.8 times that for the root of
///          three squares: less than kError of the lengths, which is subtracted from every bound. The lengths are those
///          of the lists and of the offset between their centres; the offset is computed in double. An error in the
///          direction of the centres does no harm, because the gap along any direction is a bound. No product is fused
///          with a sum, so that the bits are the same on every processor.
class LeafGaps {
 public:
  static constexpr double kError = 0x1p-17;  // 128 u

  /// [m] The squares of lengths that are a few times as long are finite in float.
  static constexpr double kMostReach = 1e15;

  explicit LeafGaps(const lanes::Kernels& kernels = lanes::kernels());

  struct Gap {
    double lower_bound;  ///< [m] of the distance minus the padding
    int number;          ///< of the pair; unlike the order of the gaps, it does not depend on the processor
    int a, b;            ///< leaves, as numbers of volumes
  };

  /// The pairs of leaves whose distance minus the padding may be at most the limit [m], in any order. Valid until the
  /// next call.
  const std::vector<Gap>& between(const LeafBoxes& a, const LeafBoxes& b, const RelativePose& a_T_b, double padding,
                                  double limit);

  /// [m] The smallest lower bound of all other pairs; infinity if there are none.
  double smallestOfOthers() const { return smallest_of_others_; }

 private:
  const lanes::Kernels& kernels_;
  std::vector<lanes::LeafGap> found_;
  std::vector<Gap> gaps_;
  double smallest_of_others_ = std::numeric_limits<double>::infinity();
};

}  // namespace proximity_server::scene
