#pragma once

#include <array>
#include <memory>

#include "tools/second_opinion/placed_pieces.h"

namespace proximity_server::tools {

/// What another library says of two links or objects.
struct OtherAnswer {
  enum class Kind : unsigned char {
    NoShape,   ///< it has no shape for one of the two, so it was not asked
    Distance,  ///< a signed distance
    Overlap    ///< an overlap without its depth
  };
  Kind kind = Kind::NoShape;
  double distance = 0.0;                       ///< [m] of Distance
  std::array<double, 3> point_a{}, point_b{};  ///< its nearest points, in the frame of the pieces
};

/// A library that is asked about the same pairs. It may throw, abort or never end: it lives in a child process.
class OtherLibrary {
 public:
  virtual ~OtherLibrary() = default;
  virtual OtherAnswer ask(const PlacedPieces& a, const PlacedPieces& b) = 0;
};

/// FCL, with the solver that it uses by default (libccd), over the same convex pieces; flat ones are triangles. The distance
/// of two bodies is that of their closest pieces, and the depth that of their deepest: both from fcl::distance(), the
/// depth with enable_signed_distance, and none where triangles overlap.
/// Failure: throws std::logic_error if this build has no FCL.
std::unique_ptr<OtherLibrary> makeFcl();

/// Whether makeFcl() succeeds.
bool hasFcl();

}  // namespace proximity_server::tools
