#include "scene/lanes/lane_bounds.h"

#include "proximity_server/narrowphase/assertion.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr float kNever = std::numeric_limits<float>::quiet_NaN();  // no limit of a search

// After so many steps, nearly all pairs are settled that a search can settle; measured with Panda and PR2 at 5 cm.
constexpr int kCoarseSteps = 4, kFullSteps = 8;
static_assert(kCoarseSteps + kFullSteps <= lanes::kMostSteps);

lanes::SearchEffort coarseSearch(const LaneModel::Pair& pair) {
  return {pair.coarse_corners_a, pair.coarse_corners_b, pair.coarse_uncovered, kCoarseSteps};
}
lanes::SearchEffort fullSearch(const lanes::PairShapes& shapes) {
  return {shapes.outline_a.count, shapes.outline_b.count, shapes.uncovered, kFullSteps};
}

}  // namespace

LaneBounds::LaneBounds(const SceneModel& model)
    : LaneBounds(std::make_shared<const LaneModel>(model, Volumes(model.robot))) {}

LaneBounds::LaneBounds(std::shared_ptr<const LaneModel> model, const lanes::Kernels& kernels)
    : model_(std::move(model)),
      kernels_(&kernels),
      is_placed_(kBlock, 0),
      sines_(model_->turns.size()),
      cosines_(model_->turns.size()),
      positions_(model_->slides.size()),
      body_poses_(kBlock / lanes::kTile * model_->bodies.size()),
      link_poses_(kBlock / lanes::kTile * model_->links.size()),
      column_(kBlock, 0.0),
      items_(std::make_unique<lanes::Items>()),
      near_(kBlock, 0),
      places_(kBlock, 0),
      pieces_(model_, kernels) {
  std::memset(items_.get(), 0, sizeof(lanes::Items));
  sides_.reserve(kBlock);
}

// --- frames

/// Computes a position for each state of the block. A position that is beyond the limit, or not finite, becomes 0, and
/// its state counts as not placed.
void LaneBounds::takePositions(const States& states, const LaneModel::Column& column) {
  const double* position = states.data() + column.joint * states.colStride();
  for (int i = 0; i < count_; ++i, position += states.rowStride()) {
    const double value = column.offset + column.multiplier * *position;
    const bool is_legal = std::abs(value) <= column.limit;
    column_[i] = is_legal ? value : 0.0;
    is_placed_[i] = static_cast<unsigned char>(is_placed_[i] & is_legal);
  }
}

void LaneBounds::place(const States& states) {
  PROXIMITY_ASSERT(states.rows() <= kBlock,
                   "There are more states than the lanes have room for: place them in blocks.");
  count_ = static_cast<int>(states.rows());
  std::fill(is_placed_.begin(), is_placed_.begin() + count_, static_cast<unsigned char>(1));
  for (std::size_t row = 0; row < model_->turns.size(); ++row) {
    takePositions(states, model_->turns[row]);
    kernels_->sinesAndCosines(column_.data(), count_, sines_[row].row, cosines_[row].row);
  }
  for (std::size_t row = 0; row < model_->slides.size(); ++row) {
    takePositions(states, model_->slides[row]);
    for (int i = 0; i < count_; ++i) positions_[row].row[i] = column_[i];
  }
  for (const int joint : model_->unread)
    for (int i = 0; i < count_; ++i)
      is_placed_[i] = static_cast<unsigned char>(is_placed_[i] & std::isfinite(states(i, joint)));
  kernels_->placeBodiesAndLinks({model_->bodies.data(), static_cast<int>(model_->bodies.size()), tilesOf(body_poses_)},
                                {model_->links.data(), static_cast<int>(model_->links.size()), tilesOf(link_poses_)},
                                count_, rowsOf(sines_), rowsOf(cosines_), rowsOf(positions_));
}

std::vector<Eigen::Isometry3d> LaneBounds::bodyPoses(int state) const {
  const std::size_t bodies = model_->bodies.size(), first = static_cast<std::size_t>(state / lanes::kTile) * bodies;
  std::vector<Eigen::Isometry3d> poses(bodies, Eigen::Isometry3d::Identity());
  for (std::size_t body = 0; body < bodies; ++body) {
    const lanes::WideTile& rows = body_poses_[first + body].tile;
    const auto number = [&](int row) { return rows[row][state % lanes::kTile]; };
    for (int k = 0; k < 9; ++k) poses[body].linear()(k / 3, k % 3) = number(k);
    for (int k = 0; k < 3; ++k) poses[body].translation()[k] = number(9 + k);
  }
  return poses;
}

void LaneBounds::placePoint(int body, const Eigen::Vector3d& point, float* x, float* y, float* z) const {
  const std::size_t bodies = model_->bodies.size();
  for (int first = 0; first < count_; first += lanes::kTile) {
    const lanes::WideTile& tile = body_poses_[static_cast<std::size_t>(first / lanes::kTile) * bodies + body].tile;
    for (int i = 0; i < lanes::kTile; ++i) {
      const auto along = [&](int row) {
        return static_cast<float>(
            ((tile[3 * row][i] * point[0] + tile[3 * row + 1][i] * point[1]) + tile[3 * row + 2][i] * point[2]) +
            tile[9 + row][i]);
      };
      x[first + i] = along(0);
      y[first + i] = along(1);
      z[first + i] = along(2);
    }
  }
}

// --- bounds

/// Returns the poses of both links of a pair. Both have geometry.
lanes::PairPoses LaneBounds::posesOf(const LaneModel::Pair& pair) const {
  return {&link_poses_[pair.a].tile, &link_poses_[pair.b].tile, static_cast<int>(model_->links.size())};
}

int LaneBounds::keepNear(int pair, double threshold, int* states, int count) const {
  const LaneModel::Pair& shapes = pairAt(pair);
  if (!shapes.hasGeometry()) return 0;
  const double reach = shapes.reach + threshold;
  if (!(reach >= 0.0)) return 0;
  // The square of a distance in float has a relative error of 2 u from the differences and of 4 u from products and
  // sums.
  const float limit = roundedUp(reach * reach * (1.0 + 0x1p-20));
  const int end = count > 0 ? 1 + *std::max_element(states, states + count) : 0;
  kernels_->markNear(posesOf(shapes), end, limit, near_.data());
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    states[kept] = states[i];
    kept += near_[states[i]];
  }
  return kept;
}

int LaneBounds::findNear(int pair, const double* thresholds, int* states) const {
  const LaneModel::Pair& shapes = pairAt(pair);
  return shapes.hasGeometry() ? kernels_->findNear(posesOf(shapes), count_, shapes.reach, thresholds, states) : 0;
}

double LaneBounds::ballGap(int pair, int state) const {
  const LaneModel::Pair& shapes = pairAt(pair);
  const std::size_t first = static_cast<std::size_t>(state / lanes::kTile) * model_->links.size();
  const lanes::Tile &a = link_poses_[first + shapes.a].tile, &b = link_poses_[first + shapes.b].tile;
  const int i = state % lanes::kTile;
  const float x = b[9][i] - a[9][i], y = b[10][i] - a[10][i], z = b[11][i] - a[11][i];  // between the origins
  return (1.0 - 0x1p-20) * std::sqrt(static_cast<double>((x * x + y * y) + z * z)) - shapes.reach;
}

void LaneBounds::travel(double* travel) const {
  if (link_poses_.empty()) return;
  kernels_->travel(&link_poses_.front().tile, static_cast<int>(model_->links.size()), model_->link_balls.data(), count_,
                   travel);
}

void LaneBounds::bounds(int pair, const int* states, int count, float* lower, float* upper) const {
  lowerBounds(pair, states, count, kInfinity, lower);
  const LaneModel::Pair& shapes = pairAt(pair);
  if (!shapes.hasGeometry()) {
    std::fill(upper, upper + count, kFloatInfinity);
    return;
  }
  kernels_->boundByInnerBalls(shapes.shapes, count, *items_);
  for (int i = 0; i < count; ++i) upper[i] = roundedUp(static_cast<double>(items_->upper[i]) - shapes.padding);
}

void LaneBounds::lowerBounds(int pair, const int* states, int count, double limit, float* lower) const {
  const LaneModel::Pair& shapes = pairAt(pair);
  if (!shapes.hasGeometry()) {
    std::fill(lower, lower + count, -kFloatInfinity);
    return;
  }
  const lanes::PairShapes& of = shapes.shapes;
  kernels_->relativePoses(posesOf(shapes), states, count, of, *items_);
  const lanes::SearchLimits limits{roundedUp(limit + shapes.padding), kNever};
  kernels_->boundByOutlines(of, coarseSearch(shapes), limits, count, *items_);
  for (int i = 0; i < count; ++i) lower[i] = roundedDown(static_cast<double>(items_->lower[i]) - shapes.padding);
}

void LaneBounds::boundPieces(int pair, const int* states, int count, const double* limits, double accuracy,
                             float* lower, float* upper) const {
  const LaneModel::Pair& shapes = pairAt(pair);
  if (!shapes.hasGeometry() || !model_->hasFewPieces(shapes)) return;
  for (int first = 0; first < count; first += PieceBounds::kMostItems) {
    const int items = std::min(PieceBounds::kMostItems, count - first);
    kernels_->relativePoses(posesOf(shapes), states + first, items, shapes.shapes, *items_);
    pieces_.narrow(shapes, *items_, limits + first, accuracy, items, lower + first, upper + first);
  }
}

/// Stores the sides of the decided items and moves the undecided ones together. Returns the number of undecided items.
int LaneBounds::keepUndecided(const lanes::SearchLimits& limits, int count) const {
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    const auto place = static_cast<std::size_t>(places_[i]);
    if (items_->lower[i] > limits.above) {
      sides_[place] = Side::Above;
    } else if (items_->upper[i] <= limits.below) {
      sides_[place] = Side::Below;
    } else {
      if (kept != i) {
        for (Row& row : items_->pose) row[kept] = row[i];
        for (Row& row : items_->cso_point) row[kept] = row[i];
        items_->lower[kept] = items_->lower[i];
        items_->upper[kept] = items_->upper[i];
        places_[kept] = places_[i];
      }
      ++kept;
    }
  }
  return kept;
}

const std::vector<LaneBounds::Side>& LaneBounds::sides(int pair, double threshold, const int* states, int count) const {
  sides_.assign(static_cast<std::size_t>(count), Side::Unknown);
  const LaneModel::Pair& shapes = pairAt(pair);
  if (!shapes.hasGeometry()) return sides_;
  const lanes::PairShapes& of = shapes.shapes;
  const lanes::SearchLimits limits{roundedUp(threshold + shapes.padding + kSettledFor),
                                   roundedDown(threshold + shapes.padding)};
  std::iota(places_.begin(), places_.begin() + count, 0);
  kernels_->relativePoses(posesOf(shapes), states, count, of, *items_);
  count = keepUndecided(limits, count);
  kernels_->boundByOutlines(of, coarseSearch(shapes), limits, count, *items_);
  count = keepUndecided(limits, count);
  kernels_->boundByInnerBalls(of, count, *items_);
  count = keepUndecided(limits, count);
  kernels_->boundByOutlines(of, fullSearch(of), limits, count, *items_);
  count = keepUndecided(limits, count);
  kernels_->boundByInnerBalls(of, count, *items_);
  keepUndecided(limits, count);
  return sides_;
}

}  // namespace proximity_server::scene
