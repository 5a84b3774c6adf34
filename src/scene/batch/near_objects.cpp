#include "scene/batch/near_objects.h"

#include "scene/model/numbers.h"

#include <algorithm>
#include <utility>

namespace proximity_server::scene {

using Eigen::Vector3d;

NearObjects::NearObjects(std::shared_ptr<const BatchModel> batch) : batch_(std::move(batch)) {
  if (!hasPairs()) return;
  const BatchObjects& objects = *batch_->objects;
  double reach = 0.0, radius = 0.0;
  for (const BatchObjects::Carried& carried : objects.carried) {
    reach = std::max(reach, batch_->lanes->body_errors[carried.body].reach + carried.centre.norm());
    if (carried.radius < kInfinity) radius = std::max(radius, carried.radius);
  }
  edge_ = 2.0 * reach / kCells;
  per_metre_ = 1.0 / edge_;
  horizon_ = 2.0 * (radius + edge_);
  places_.resize(objects.carried.size());
  centres_.resize(objects.carried.size());
  radii_.resize(objects.carried.size());
  if (objects.fixed.empty() || !(edge_ > 0.0)) return;
  cell_at_.assign(kCells * kCells * kCells, -1);
  cells_.reserve(cell_at_.size());  // takes no memory before cells are filled
  known_.reserve(kKnown + 1);
}

void NearObjects::place(const LaneBounds& lanes) {
  lanes_ = &lanes;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const BatchObjects::Carried& carried = batch_->objects->carried[i];
    lanes.placePoint(carried.body, carried.centre, places_[i].x.data(), places_[i].y.data(), places_[i].z.data());
  }
}

void NearObjects::takeCentres(int state, ExactState& exact) {
  const bool is_in_lanes = lanes_->isPlaced(state);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const BatchObjects::Carried& carried = batch_->objects->carried[i];
    const Places& places = places_[i];
    centres_[i] = is_in_lanes ? Vector3d(places.x[state], places.y[state], places.z[state])
                              : exact.poseOf(carried.body) * carried.centre;
    radii_[i] = carried.radius + carried.lane_error + (is_in_lanes ? 0.0 : kPoseRounding * centres_[i].norm());
  }
}

// --- cells

const NearObjects::Cell* NearObjects::cellAt(const Vector3d& point) {
  if (cell_at_.empty()) return nullptr;
  const Eigen::Array3d place = point.array() * per_metre_ + 0.5 * kCells;
  if (!((place >= 0.0).all() && (place < kCells).all())) return nullptr;
  const Eigen::Array3i index = place.cast<int>();
  int& cell = cell_at_[(index.x() * kCells + index.y()) * kCells + index.z()];
  if (cell < 0) {
    cell = static_cast<int>(cells_.size());
    cells_.emplace_back();
    cells_.back().middle = (index.cast<double>() + (0.5 - 0.5 * kCells)) * edge_;
    fill(cells_.back());
  }
  return &cells_[cell];
}

/// Finds the objects nearest to the middle of a cell.
void NearObjects::fill(Cell& cell) {
  known_.clear();
  for (const int fixed_object : batch_->objects->unbounded) offer(cell, fixed_object);
  const auto limit = [&] {
    // The distance of a box is not negative, so it tells nothing about objects around the middle.
    const double farthest = std::max(0.0, farthestKnown());
    return (1.0 + kPoseRounding) * farthest * farthest;
  };
  batch_->objects->tree.visitNearest(
      [&](const Eigen::AlignedBox3d& box) { return box.squaredExteriorDistance(cell.middle); }, limit,
      [&](int fixed_object) { offer(cell, fixed_object); });
  cell.of_others = (1.0 - kPoseRounding) * farthestKnown();
  for (const auto& [distance, fixed_object] : known_.sorted())
    cell.nearest[static_cast<std::size_t>(cell.count++)] = {fixed_object, roundedDown(distance)};
}

/// Keeps an object if it is one of the nearest.
void NearObjects::offer(const Cell& cell, int fixed_object) {
  const double distance = batch_->objects->distanceFrom(cell.middle, fixed_object, farthestKnown());
  if (!(distance < farthestKnown())) return;
  known_.push({distance, fixed_object});
  if (known_.size() > kKnown) known_.pop();
}

// --- one state

const std::vector<Visit>& NearObjects::within(double limit, int state, ExactState& exact) {
  near_.clear();
  takeCentres(state, exact);
  const BatchObjects& objects = *batch_->objects;
  for (const BatchObjects::CarriedPair& pair : objects.carried_pairs) {
    const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
    const double between = (1.0 - kPoseRounding) * (centres_[b] - centres_[a]).norm();
    add(pair.number, between - radii_[a] - radii_[b], limit);
  }
  if (objects.fixed.empty()) return near_;
  for (std::size_t i = 0; i < centres_.size(); ++i) {
    const Cell* const cell = cellAt(centres_[i]);
    const double reach =
        limit + radii_[i] + (cell ? (1.0 + kPoseRounding) * (centres_[i] - cell->middle).norm() : kInfinity);
    if (!cell || !(cell->of_others > reach)) {
      addFixed(static_cast<int>(i), limit);
      continue;
    }
    for (const Known *known = cell->nearest.data(), *end = known + cell->count; known != end; ++known) {
      if (known->distance > reach) break;
      add(static_cast<int>(i), known->fixed_object, limit);
    }
  }
  return near_;
}

/// Adds the pairs of one that is carried with fixed objects, by the hierarchy of the objects.
void NearObjects::addFixed(int carried, double limit) {
  const BatchObjects& objects = *batch_->objects;
  const double reach = std::max(0.0, limit + radii_[carried]);  // the distance of a box is not negative
  for (const int fixed_object : objects.unbounded) add(carried, fixed_object, limit);
  objects.tree.visitNearest(
      [&](const Eigen::AlignedBox3d& box) { return (1.0 - kPoseRounding) * box.exteriorDistance(centres_[carried]); },
      [&] { return reach; },
      [&](int fixed_object) {
        if (!objects.fixed[fixed_object]->box.isEmpty()) add(carried, fixed_object, limit);
      });
}

void NearObjects::add(int carried, int fixed_object, double limit) {
  const BatchObjects& objects = *batch_->objects;
  const int number = objects.numbers[carried][fixed_object];
  if (number < 0) return;
  const double radius = radii_[carried];
  add(number, objects.distanceFrom(centres_[carried], fixed_object, limit + radius) - radius, limit);
}

/// Adds a pair, unless the lower bound of its distance is above the limit.
void NearObjects::add(int number, double distance, double limit) {
  Visit visit = batch_->visits[number];
  visit.lower_bound =
      std::max(-kInfinity, distance - visit.padding);  // NaN of a state that is too far away is no bound
  if (!(visit.lower_bound > limit)) near_.push_back(visit);
}

double NearObjects::limitOfClosest(std::size_t k, const PairDistances& thresholds, int state, ExactState& exact) {
  takeCentres(state, exact);
  uppers_.clear();
  for (std::size_t i = 0; i < centres_.size(); ++i) {
    const Cell* const cell = cellAt(centres_[i]);
    for (int known = 0; cell && known < cell->count; ++known) {
      const int fixed_object = cell->nearest[static_cast<std::size_t>(known)].fixed_object;
      const PlacedObject& object = *batch_->objects->fixed[fixed_object];
      const int number = batch_->objects->numbers[i][fixed_object];
      if (number < 0 || object.geometry->root().isEmpty()) continue;
      // Some point of each of the two is in its sphere.
      const Bounds& sphere = object.geometry->root().bounds;
      const double between = (object.world_T_object * sphere.centre - centres_[i]).norm();
      const double upper_bound = (1.0 + kPoseRounding) * between + radii_[i] + sphere.radius;
      uppers_.push_back(upper_bound - batch_->visits[number].padding - thresholds.of(batch_->pairs[number]));
    }
  }
  if (uppers_.size() < k) return kInfinity;
  const auto kth = uppers_.begin() + static_cast<std::ptrdiff_t>(k) - 1;
  std::nth_element(uppers_.begin(), kth, uppers_.end());
  return *kth;
}

}  // namespace proximity_server::scene
