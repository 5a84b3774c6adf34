// Bounds of all pairs of leaves at once, beside the distances of the pieces and the bounds of Bounds.
#include "scene/bounds/leaf_boxes.h"

#include "chance.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace proximity_server::scene::leaf_boxes_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::randomPose;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Boxes, each a piece of one link, at most so far from a point of their body.
class Boxes {
 public:
  Boxes(Chance& random, int count, double reach, const Vector3d& point = Vector3d::Zero()) {
    std::uniform_real_distribution<double> length(0.001, 0.5);
    std::vector<int> numbers;
    for (int i = 0; i < count; ++i) {
      Isometry3d pose = randomPose(random, reach);
      pose.pretranslate(point);
      pieces_.push_back({narrowphase::Box{Vector3d(length(random), length(random), length(random))}, pose, 0});
      numbers.push_back(i);
    }
    const VolumeBuilder builder(pieces_, std::vector<Representation>(pieces_.size(), Representation::Exact));
    const Volume root = builder.over(numbers, volumes_);
    volumes_.push_back(root);
  }
  /// All of them, if they are few.
  LeafBoxes leaves() {
    std::vector<WideVolume> wide;
    addWideVolumes(volumes_, static_cast<int>(volumes_.size()) - 1, wide);
    return wide.front().parts();
  }
  const std::vector<Volume>& volumes() const { return volumes_; }
  const Volume& at(int leaf) const { return volumes_[leaf]; }
  const Piece& pieceOf(int leaf) const { return pieces_[at(leaf).piece]; }

 private:
  std::vector<Piece> pieces_;
  std::vector<Volume> volumes_;
};

RelativePose relativePose(const Isometry3d& pose) { return {pose.linear(), pose.translation()}; }

/// The larger of the bounds of Bounds, in double.
double boundOf(const Volume& a, const Volume& b, const RelativePose& a_T_b) {
  return std::max(sphereGap(a.bounds, b.bounds, a_T_b), boxGap(a.bounds, b.bounds, a_T_b));
}

TEST(LeafGaps, AreLowerBoundsOfTheDistances) {
  Chance random(1);
  for (const double reach : {0.3, 3.0, 1000.0}) {
    for (int i = 0; i < repeats(200); ++i) {
      const int count = 1 + i % 9;
      Boxes boxes_a(random, count, 0.3), boxes_b(random, 10 - count, 0.3);
      const LeafBoxes a = boxes_a.leaves(), b = boxes_b.leaves();
      const Isometry3d pose = randomPose(random, reach);
      const RelativePose a_T_b = relativePose(pose);
      LeafGaps gaps;
      const std::vector<LeafGaps::Gap> found = gaps.between(a, b, a_T_b, 0.0, kInfinity);
      ASSERT_EQ(found.size(), a.leaves().size() * b.leaves().size());
      EXPECT_EQ(gaps.smallestOfOthers(), kInfinity);
      for (const LeafGaps::Gap& gap : found) {
        const Piece &piece_a = boxes_a.pieceOf(gap.a), &piece_b = boxes_b.pieceOf(gap.b);
        const Isometry3d pieces = piece_a.body_T_piece.inverse() * pose * piece_b.body_T_piece;
        ASSERT_LE(gap.lower_bound, signedDistance(piece_a.shape, piece_b.shape, pieces).upper_bound);
        const double in_double = boundOf(boxes_a.at(gap.a), boxes_b.at(gap.b), a_T_b);
        const double lengths =
            pose.translation().norm() + a.centre().norm() + b.centre().norm() + a.reach() + b.reach();
        ASSERT_LE(gap.lower_bound, in_double);
        ASSERT_LE(in_double - gap.lower_bound, 2.0 * LeafGaps::kError * lengths);
      }
    }
  }
}

TEST(LeafGaps, AreTightFarFromTheOriginsOfTheBodies) {
  Chance random(5);
  const Vector3d point(4e5, -5e6, 100.0);  // as in a map of a country
  for (int i = 0; i < repeats(200); ++i) {
    Boxes boxes_a(random, 4, 0.3, point), boxes_b(random, 4, 0.3);
    const LeafBoxes a = boxes_a.leaves(), b = boxes_b.leaves();
    Isometry3d pose = randomPose(random, 1.0);
    pose.pretranslate(point);
    LeafGaps gaps;
    for (const LeafGaps::Gap& gap : gaps.between(a, b, relativePose(pose), 0.0, kInfinity)) {
      const double in_double = boundOf(boxes_a.at(gap.a), boxes_b.at(gap.b), relativePose(pose));
      const double lengths = (pose * b.centre() - a.centre()).norm() + a.reach() + b.reach();
      const double allowed = 2.0 * LeafGaps::kError * lengths + 4.0 * kPoseRounding * point.norm();
      ASSERT_NEAR(gap.lower_bound, in_double, allowed);
      const Piece &piece_a = boxes_a.pieceOf(gap.a), &piece_b = boxes_b.pieceOf(gap.b);
      const Isometry3d pieces = piece_a.body_T_piece.inverse() * pose * piece_b.body_T_piece;
      ASSERT_LE(gap.lower_bound, signedDistance(piece_a.shape, piece_b.shape, pieces).upper_bound);
    }
  }
}

TEST(LeafGaps, LeaveOutOnlyWhatIsBeyondTheLimit) {
  Chance random(2);
  std::uniform_real_distribution<double> some(-0.1, 1.0);
  int left_out = 0, kept = 0;
  for (int i = 0; i < repeats(300); ++i) {
    Boxes boxes_a(random, 1 + i % LeafBoxes::kMostLeaves, 0.5), boxes_b(random, 1 + i % 7, 0.5);
    const LeafBoxes a = boxes_a.leaves(), b = boxes_b.leaves();
    const Isometry3d pose = randomPose(random, 1.0);
    const RelativePose a_T_b = relativePose(pose);
    const double limit = some(random), padding = 0.01 * some(random);
    LeafGaps gaps;
    std::map<std::pair<int, int>, double> all;
    for (const LeafGaps::Gap& gap : gaps.between(a, b, a_T_b, padding, kInfinity))
      all[{gap.a, gap.b}] = gap.lower_bound;
    for (const LeafGaps::Gap& gap : gaps.between(a, b, a_T_b, padding, limit)) {
      ASSERT_TRUE(all.count({gap.a, gap.b}));
      ASSERT_LE(gap.lower_bound, limit);
      ASSERT_EQ((all[{gap.a, gap.b}]), gap.lower_bound);
      all.erase({gap.a, gap.b});
      ++kept;
    }
    left_out += static_cast<int>(all.size());
    ASSERT_GT(gaps.smallestOfOthers(), limit);
    for (const auto& [pair, bound] : all) {
      const Piece &piece_a = boxes_a.pieceOf(pair.first), &piece_b = boxes_b.pieceOf(pair.second);
      const Isometry3d pieces = piece_a.body_T_piece.inverse() * pose * piece_b.body_T_piece;
      const double distance = signedDistance(piece_a.shape, piece_b.shape, pieces).upper_bound - padding;
      ASSERT_LE(gaps.smallestOfOthers(), distance);
    }
  }
  EXPECT_GT(left_out, kept / 10);
  EXPECT_GT(kept, left_out / 10);
}

TEST(LeafGaps, AreTheSameOnEveryKindOfProcessor) {
  Chance random(4);
  std::uniform_real_distribution<double> some(-0.1, 0.5);
  int found = 0, others = 0;
  for (int i = 0; i < repeats(300); ++i) {
    Boxes boxes_a(random, 1 + i % LeafBoxes::kMostLeaves, 0.5), boxes_b(random, 1 + i % 23, 0.5);
    const LeafBoxes a = boxes_a.leaves(), b = boxes_b.leaves();
    const RelativePose a_T_b = relativePose(randomPose(random, 1.0));
    const double limit = i % 5 == 0 ? kInfinity : some(random);
    std::map<int, LeafGaps::Gap> expected;
    double smallest = 0.0;
    for (const lanes::Kernels* const* kernels = lanes::allKernels(); *kernels; ++kernels) {
      SCOPED_TRACE((*kernels)->name);
      LeafGaps gaps(**kernels);
      std::map<int, LeafGaps::Gap> by_number;
      for (const LeafGaps::Gap& gap : gaps.between(a, b, a_T_b, 0.0, limit))
        ASSERT_TRUE(by_number.emplace(gap.number, gap).second);
      if (kernels == lanes::allKernels()) {
        expected = by_number;
        smallest = gaps.smallestOfOthers();
      }
      ASSERT_EQ(gaps.smallestOfOthers(), smallest);
      ASSERT_EQ(by_number.size(), expected.size());
      for (const auto& [number, gap] : by_number) {
        ASSERT_TRUE(expected.count(number));
        ASSERT_EQ(gap.lower_bound, expected[number].lower_bound);
        ASSERT_EQ(std::make_pair(gap.a, gap.b), std::make_pair(expected[number].a, expected[number].b));
      }
    }
    found += static_cast<int>(expected.size());
    others += static_cast<int>(a.leaves().size() * b.leaves().size() - expected.size());
  }
  EXPECT_GT(found, others / 10);
  EXPECT_GT(others, found / 10);
}

TEST(WideVolume, ReachesEachLeafOnce) {
  Chance random(3);
  constexpr int kMost = LeafBoxes::kMostLeaves;
  for (const int count : {1, 2, kMost, kMost + 1, 10 * kMost + 1}) {
    SCOPED_TRACE(count);
    Boxes boxes(random, count, 1.0);
    std::vector<Volume> volumes = boxes.volumes();
    std::vector<WideVolume> wide;
    addWideVolumes(volumes, static_cast<int>(volumes.size()) - 1, wide);
    EXPECT_EQ(wide.front().hasLeaves(), count <= kMost);
    std::vector<int> reached, open{volumes.back().wide};
    while (!open.empty()) {
      const WideVolume& here = wide[open.back()];
      open.pop_back();
      ASSERT_EQ(here.whole().leaves().size(), 1u);
      ASSERT_LE(here.parts().leaves().size(), static_cast<std::size_t>(kMost));
      for (const int part : here.parts().leaves()) {
        if (here.hasLeaves())
          reached.push_back(volumes[part].piece);
        else
          open.push_back(volumes[part].wide);
      }
    }
    std::sort(reached.begin(), reached.end());
    ASSERT_EQ(reached.size(), static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) EXPECT_EQ(reached[i], i);
  }
}

}  // namespace proximity_server::scene::leaf_boxes_test
