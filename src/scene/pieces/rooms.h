#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "proximity_server/narrowphase/shape/convex_hull.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "scene/pieces/enclosed_space.h"
#include "scene/pieces/triangle_tree.h"

namespace proximity_server::scene {

/// The empty space in a mesh that a hull around it would fill: cavities, and rooms whose openings are narrower than the
/// tolerance. The surface of the hull tells nothing of them.
///
/// The solid is where the winding number of the closed components is not 0; of all open components together it is their hull.
/// A mesh without a closed component has no rooms.
class Rooms {
 public:
  Rooms() = default;
  explicit Rooms(const std::vector<TriangleMesh>& components);

  /// The radius of the largest ball of empty space whose centre is in a hull.
  struct Largest {
    double radius;   ///< [m] that was found, at least Question::known
    double at_most;  ///< [m] that is proven to be no smaller
  };

  /// When the search ends.
  struct Question {
    /// [m] Balls up to this radius are not looked for. No ball with its centre on the surface of the hull may be larger than this
    /// or than `enough`.
    double known;
    double too_large;  ///< [m] when a larger ball is found
    double enough;     ///< [m] when it is proven that there is no larger one
    int looks;         ///< after so many boxes
  };

  /// Branch and bound over boxes, those that may hold the centre of the largest ball first. The distance from the mesh changes by
  /// no more than the way from the middle of the box. Three kinds of boxes hold no such centre: those outside of the hull;
  /// those inside of the solid; and those that a plane separates from all of the mesh that is near, as a ball that moves away
  /// from the plane can grow. May throw Effort::Exceeded.
  Largest largestIn(const narrowphase::ConvexHull& hull, const Question& question, Effort& effort) const;

 private:
  friend class RoomSearch;
  struct Part {
    explicit Part(const TriangleMesh& mesh);
    TriangleTree surface;
    EnclosedSpace space;
    int facing;  ///< the sign of its winding number; 1 where it faces outwards
  };
  std::vector<Part> parts_;
  std::optional<TriangleTree> surface_;  ///< of all parts, and of open components
};

}  // namespace proximity_server::scene
