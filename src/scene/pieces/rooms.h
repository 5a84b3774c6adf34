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

  /// What the search for it is about.
  struct Question {
    double
        known;  ///< [m] no ball with its centre on the surface of the hull is larger, and up to this none is looked for
    double too_large;  ///< [m] the search ends when one is found that is larger
    double enough;     ///< [m] it ends when it is proven that none is larger
    int looks;         ///< it ends after so many boxes
  };

  /// Branch and bound over boxes, those that may hold the largest ball first. A box is settled where it is outside of the hull,
  /// or wholly inside of the solid. The distance from the mesh changes by no more than the way from the middle of the box.
  /// Where all of the mesh near to a box lies on one side of it, a larger ball is found farther away from that side, so that
  /// the centre of the largest is elsewhere. May throw Effort::Exceeded.
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
