#pragma once

#include "proximity_server/scene/query/pair_distances.h"
#include "scene/batch/exact_state.h"
#include "scene/bounds/heap.h"
#include "scene/lanes/lane_bounds.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// Finds the pairs with objects that may be near in a state. Carried objects are spheres, see BatchObjects.
///
/// 1. Place the centres of the spheres in a block of states, from the poses that the lanes have.
/// 2. The space that the centres can reach is divided into cells. Each cell knows the fixed objects nearest to its
///    middle. They are found in the hierarchy of the objects when a centre is first in the cell.
/// 3. For each sphere, take the objects of its cell while they may be within the limit, and improve the bound by the
///    distance of the centre itself. If the cell does not know all objects within the limit, search the hierarchy.
/// 4. Pairs of two spheres are few, and are compared one by one.
///
/// A bound depends on the state alone, as a cell does not depend on the centre that was first there.
class NearObjects {
 public:
  explicit NearObjects(std::shared_ptr<const BatchModel> batch);

  /// False if no pair with an object is checked.
  bool hasPairs() const { return batch_->pairs.size() > batch_->candidates.size(); }

  /// Takes the states of a block.
  void place(const LaneBounds& lanes);

  /// The pairs whose distance may be at most the limit [m], each with a lower bound by spheres. `exact` has the state.
  /// Valid until the next call.
  const std::vector<Visit>& within(double limit, int state, ExactState& exact);

  /// [m] An upper bound of the k-th smallest distance minus the threshold of the pair; infinity if it is not known.
  double limitOfClosest(std::size_t k, const PairDistances& thresholds, int state, ExactState& exact);

 private:
  static constexpr int kCells = 40;  ///< along each axis
  static constexpr int kKnown = 16;  ///< objects of a cell

  struct Known {
    int fixed_object;
    float distance;  ///< [m] lower bound of the distance from the middle of the cell
  };
  struct Cell {
    Eigen::Vector3d middle;
    double of_others = 0.0;  ///< [m] the same for all objects that the cell does not know
    int count = 0;
    std::array<Known, kKnown> nearest;  ///< the nearest first
  };
  struct Places {
    std::array<float, LaneBounds::kBlock> x, y, z;
  };

  void takeCentres(int state, ExactState& exact);
  const Cell* cellAt(const Eigen::Vector3d& point);
  void fill(Cell& cell);
  void offer(const Cell& cell, int fixed_object);
  double farthestKnown() const { return known_.size() < kKnown ? horizon_ : known_.first().first; }
  void addFixed(int carried, double limit);
  void add(int carried, int fixed_object, double limit);
  void add(int number, double distance, double limit);

  std::shared_ptr<const BatchModel> batch_;
  double edge_ = 0.0;         ///< [m] of a cell
  double per_metre_ = 0.0;    ///< the number of cells
  double horizon_ = 0.0;      ///< [m] A cell knows no objects that are farther away
  std::vector<int> cell_at_;  ///< index into `cells_`; -1: no centre was there
  std::vector<Cell> cells_;
  const LaneBounds* lanes_ = nullptr;
  std::vector<Places> places_;            ///< of the centres in the states of the block
  std::vector<Eigen::Vector3d> centres_;  ///< in the current state
  std::vector<double> radii_;             ///< [m] of the spheres, with the errors of the centres
  Heap<std::pair<double, int>> known_;    ///< of the cell that is filled, the farthest first
  std::vector<double> uppers_;
  std::vector<Visit> near_;
};

}  // namespace proximity_server::scene
