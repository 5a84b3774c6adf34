#pragma once

#include "proximity_server/scene/objects/objects.h"
#include "scene/bounds/box_tree.h"
#include "scene/lanes/lane_model.h"
#include "scene/state/visit_queue.h"
#include "scene/state/volumes.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <memory>
#include <vector>

namespace proximity_server::scene {

/// The checked pairs with objects, as a search of many states needs them. It never changes; the batches of all threads
/// share it.
struct BatchObjects {
  /// The visits of the pairs with objects begin at `first`; their indices are the numbers of the pairs.
  /// Failure: throws std::invalid_argument naming a moving object whose frame is not a link.
  BatchObjects(std::shared_ptr<const Objects> objects, const std::vector<Visit>& visits, std::size_t first,
               const Volumes& volumes, const LaneModel& lanes);

  /// A link, or an object that moves with a link, as a sphere on a body of the robot.
  struct Carried {
    int body;
    Eigen::Vector3d centre;  ///< in the frame of the body
    double radius;           ///< [m] infinity if it has half-spaces
    double lane_error;       ///< [m] of the centre, if it is computed from the pose of the body in the lanes
  };

  struct CarriedPair {
    int number, a, b;
  };

  /// [m] A lower bound of the signed distance of a point from a fixed object; any larger number if it is at least
  /// `most`.
  double distanceFrom(const Eigen::Vector3d& point, int fixed_object, double most) const;

  std::shared_ptr<const Objects> objects;
  std::vector<int> frame_links;  ///< for each of Objects::frames(): its link
  std::vector<Carried> carried;
  std::vector<CarriedPair> carried_pairs;
  std::vector<const PlacedObject*> fixed;  ///< the fixed objects of a checked pair
  std::vector<int> unbounded;              ///< the fixed objects with half-spaces, as indices into `fixed`
  BoxTree tree;                            ///< of all others; the items are indices into `fixed`
  std::vector<std::vector<int>> numbers;   ///< of the pair of one that is carried and a fixed object; -1: not checked

 private:
  void addCarried(const Part& part, const LaneModel& lanes);
};

}  // namespace proximity_server::scene
