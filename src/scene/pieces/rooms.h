#pragma once

#include "proximity_server/narrowphase/shape/convex_hull.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "scene/pieces/enclosed_space.h"
#include "scene/pieces/triangle_tree.h"

#include <Eigen/Geometry>

#include <atomic>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// A room is empty space in a mesh that a hull around the mesh would fill: a cavity, or a hollow whose openings are
/// narrower than the tolerance. The surface of the hull does not show it.
///
/// The solid is where the winding number of the closed components is not 0. The solid of all open components together
/// is their hull. A mesh without a closed component has no rooms.
class Rooms {
 public:
  Rooms() = default;
  explicit Rooms(const std::vector<TriangleMesh>& components, const std::atomic<bool>* stop = nullptr);

  /// The radius of the largest ball of empty space whose centre is in a hull.
  struct Largest {
    double radius;   ///< [m] the radius of the largest ball found, at least Question::known
    double at_most;  ///< [m] a proven upper bound of the radius
    /// A point of the hull: the centre of that ball, or, if at_most is larger, one near the centre of a ball that was not
    /// excluded. Meaningless if at_most is not above Question::enough.
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  };

  /// The facts that are known at the start of a search, and the conditions that end it.
  struct Question {
    /// [m] Balls up to this radius are not searched for. No ball with its centre on the surface of the hull may be
    /// larger than this or than `enough`.
    double known;
    double too_large;  ///< [m] the search ends when a ball larger than this is found
    double enough;     ///< [m] the search ends when it is proven that no ball is larger than this
    int looks;         ///< the search ends after so many boxes
  };

  /// Searches by branch and bound over boxes; the box that may hold the centre of the largest ball comes first. The
  /// distance from the mesh changes by no more than the distance from the middle of the box. Four kinds of boxes
  /// cannot hold that centre: boxes outside of the hull; boxes inside of the solid; boxes that a plane separates from all
  /// of the mesh that is near, as a ball that moves away from the plane can grow; and boxes near which all of the mesh
  /// faces into one half of all directions, as a ball that moves there can grow. If the effort is spent, `at_most` is
  /// a coarse bound.
  Largest largestIn(const narrowphase::ConvexHull& hull, const Question& question, Effort& effort) const;

 private:
  friend class RoomSearch;
  struct Part {
    explicit Part(const TriangleMesh& mesh);
    TriangleTree surface;
    EnclosedSpace space;
    int facing;  ///< The sign of its winding number: 1 if it faces outwards.
  };
  std::vector<Part> parts_;
  std::optional<TriangleTree> surface_;  ///< the surface of all parts and of the open components
};

}  // namespace proximity_server::scene
