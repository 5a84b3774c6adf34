#pragma once

#include "scene/kernels/lane_kernels.h"
#include "scene/lanes/lane_model.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace proximity_server::scene {

/// Bounds the distance of two links by the distances of their convex pieces, in many states at once. It has the working
/// memory of one caller.
///
/// 1. The boxes of all pieces give lower bounds.
/// 2. GJK bounds the two pieces whose boxes are nearest in each state.
/// 3. GJK bounds all other pieces whose boxes are nearer than the upper bound so far.
///
/// If one link may be inside of the interior of the other, the boxes of the two are the lower bound.
class PieceBounds {
 public:
  PieceBounds(std::shared_ptr<const LaneModel> model, const lanes::Kernels& kernels);

  static constexpr int kMostItems = 128;

  /// Narrows the bounds of a pair in up to kMostItems items, see LaneBounds::boundPieces().
  void narrow(const LaneModel::Pair& pair, const lanes::Items& items, const double* limits, double accuracy, int count,
              float* lower, float* upper);

 private:
  struct alignas(64) Part {  // of the items
    float gaps[lanes::kTile];
  };
  float* gapsOf(std::size_t pieces) { return gaps_[pieces * stride_ / lanes::kTile].gaps; }
  void findGaps(const lanes::Boxes& a, const lanes::Boxes& b, float error, const lanes::Items& items);
  void boundInteriors(const LaneModel::Pair& pair, const lanes::Items& items, float* lower);
  void findClosest(std::size_t pieces);
  template <typename IsWanted>
  void boundWhere(const LaneModel::Pair& pair, const lanes::Items& items, const IsWanted& isWanted);
  void boundCores(const LaneModel::Pair& pair, std::size_t pieces, const lanes::Items& items);

  std::shared_ptr<const LaneModel> model_;
  const lanes::Kernels* kernels_;
  std::vector<Part> gaps_;  ///< [m] the lower bound of each pair of pieces: the items of one after the items of another
  std::size_t stride_ = 0;  ///< from one pair of pieces to the next
  std::size_t count_ = 0;
  float accuracy_ = 0.0f;                        ///< [m]
  std::vector<float> limits_, lowers_, uppers_;  ///< [m] of the items, without padding
  std::vector<int> closest_;                     ///< for each item: the pair of pieces with the smallest gap
  std::vector<int> asked_;                       ///< the items that GJK is asked about
  std::vector<float> asked_limits_, asked_lowers_, asked_uppers_;
};

}  // namespace proximity_server::scene
