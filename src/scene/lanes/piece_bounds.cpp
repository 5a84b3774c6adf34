#include "scene/lanes/piece_bounds.h"

#include "scene/model/numbers.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace proximity_server::scene {
namespace {

lanes::Boxes boxesOf(const LaneModel::BoxRows& rows) {
  return {static_cast<int>(rows[0].size()),
          {rows[0].data(), rows[1].data(), rows[2].data()},
          {rows[3].data(), rows[4].data(), rows[5].data()}};
}

}  // namespace

PieceBounds::PieceBounds(std::shared_ptr<const LaneModel> model, const lanes::Kernels& kernels)
    : model_(std::move(model)),
      kernels_(&kernels),
      limits_(kMostItems),
      lowers_(kMostItems),
      uppers_(kMostItems),
      closest_(kMostItems),
      asked_limits_(kMostItems),
      asked_lowers_(kMostItems),
      asked_uppers_(kMostItems) {
  asked_.reserve(kMostItems);
  std::size_t most = 1;
  for (const LaneModel::Pair& pair : model_->pairs)
    if (pair.hasGeometry() && model_->hasFewPieces(pair))
      most = std::max(most, model_->pieces[pair.a].list.size() * model_->pieces[pair.b].list.size());
  gaps_.resize(most * kMostItems / lanes::kTile);
}

void PieceBounds::narrow(const LaneModel::Pair& pair, const lanes::Items& items, const double* limits, double accuracy,
                         int count, float* lower, float* upper) {
  const LaneModel::Pieces &a = model_->pieces[pair.a], &b = model_->pieces[pair.b];
  const std::size_t pieces = a.list.size() * b.list.size();
  count_ = static_cast<std::size_t>(count);
  accuracy_ = roundedDown(accuracy);
  stride_ = (count_ + lanes::kTile - 1) / lanes::kTile * lanes::kTile;
  for (std::size_t i = 0; i < count_; ++i) {
    limits_[i] = roundedUp(limits[i] + pair.padding);
    uppers_[i] = roundedUp(static_cast<double>(upper[i]) + pair.padding);
  }
  if (pieces == 1)
    std::copy_n(items.lower, count_, gapsOf(0));
  else
    findGaps(boxesOf(a.boxes), boxesOf(b.boxes), pair.gap_error, items);
  findClosest(pieces);
  boundWhere(pair, items, [&](std::size_t i, int of, float gap) { return closest_[i] == of && gap <= limits_[i]; });
  if (pieces > 1)
    boundWhere(pair, items, [&](std::size_t i, int of, float gap) {
      return closest_[i] != of && gap <= std::min(limits_[i], uppers_[i]);
    });
  std::fill_n(lowers_.begin(), count_, kFloatInfinity);
  for (std::size_t of = 0; of < pieces; ++of)
    for (std::size_t i = 0; i < count_; ++i) lowers_[i] = std::min(lowers_[i], gapsOf(of)[i]);
  boundInteriors(pair, items, lowers_.data());
  for (std::size_t i = 0; i < count_; ++i) {
    lower[i] = std::max(lower[i], roundedDown(static_cast<double>(lowers_[i]) - pair.padding));
    upper[i] = std::min(upper[i], roundedUp(static_cast<double>(uppers_[i]) - pair.padding));
  }
}

void PieceBounds::findGaps(const lanes::Boxes& a, const lanes::Boxes& b, float error, const lanes::Items& items) {
  kernels_->boxGaps(a, b, error, static_cast<int>(count_), items, static_cast<int>(stride_), gapsOf(0));
}

void PieceBounds::findClosest(std::size_t pieces) {
  std::fill_n(lowers_.begin(), count_, kFloatInfinity);
  for (std::size_t of = 0; of < pieces; ++of) {
    const float* const gaps = gapsOf(of);
    for (std::size_t i = 0; i < count_; ++i) {
      const bool is_closer = gaps[i] < lowers_[i];
      lowers_[i] = is_closer ? gaps[i] : lowers_[i];
      closest_[i] = is_closer ? static_cast<int>(of) : closest_[i];
    }
  }
}

/// Bounds each pair of pieces in the items for which isWanted(item, pair of pieces, gap) is true.
template <typename IsWanted>
void PieceBounds::boundWhere(const LaneModel::Pair& pair, const lanes::Items& items, const IsWanted& isWanted) {
  const std::size_t pieces = model_->pieces[pair.a].list.size() * model_->pieces[pair.b].list.size();
  for (std::size_t of = 0; of < pieces; ++of) {
    asked_.clear();
    const float* const gaps = gapsOf(of);
    for (std::size_t i = 0; i < count_; ++i)
      if (isWanted(i, static_cast<int>(of), gaps[i])) asked_.push_back(static_cast<int>(i));
    if (!asked_.empty()) boundCores(pair, of, items);
  }
}

void PieceBounds::boundCores(const LaneModel::Pair& pair, std::size_t pieces, const lanes::Items& items) {
  const std::vector<LaneModel::Piece>&a = model_->pieces[pair.a].list, &b = model_->pieces[pair.b].list;
  const std::size_t of_a = pieces / b.size(), of_b = pieces % b.size();
  const double margin = a[of_a].margin + b[of_b].margin;
  for (std::size_t k = 0; k < asked_.size(); ++k) {
    const auto item = static_cast<std::size_t>(asked_[k]);
    asked_limits_[k] = roundedUp(static_cast<double>(std::min(limits_[item], uppers_[item])) + margin);
  }
  kernels_->boundByGjk(model_->coresOf(pair, of_a, of_b), accuracy_, items, asked_.data(), asked_limits_.data(),
                       static_cast<int>(asked_.size()), asked_lowers_.data(), asked_uppers_.data());
  const bool is_exact = a[of_a].is_exact && b[of_b].is_exact;
  float* const gaps = gapsOf(pieces);
  for (std::size_t k = 0; k < asked_.size(); ++k) {
    const auto item = static_cast<std::size_t>(asked_[k]);
    gaps[item] = std::max(gaps[item], roundedDown(static_cast<double>(asked_lowers_[k]) - margin));
    if (is_exact) uppers_[item] = std::min(uppers_[item], roundedUp(static_cast<double>(asked_uppers_[k]) - margin));
  }
}

/// Lowers the lower bounds where a representative of one link may be inside of an interior of the other.
void PieceBounds::boundInteriors(const LaneModel::Pair& pair, const lanes::Items& items, float* lower) {
  const LaneModel::Pieces &a = model_->pieces[pair.a], &b = model_->pieces[pair.b];
  for (const auto& [of_a, of_b] :
       {std::pair{&a.interiors, &b.representatives}, std::pair{&a.representatives, &b.interiors}}) {
    const lanes::Boxes boxes_a = boxesOf(*of_a), boxes_b = boxesOf(*of_b);
    if (boxes_a.count == 0 || boxes_b.count == 0) continue;
    findGaps(boxes_a, boxes_b, pair.gap_error, items);
    for (int of = 0; of < boxes_a.count * boxes_b.count; ++of)
      for (std::size_t i = 0; i < count_; ++i)
        if (const float gap = gapsOf(static_cast<std::size_t>(of))[i]; gap < 0.0f) lower[i] = std::min(lower[i], gap);
  }
}

}  // namespace proximity_server::scene
