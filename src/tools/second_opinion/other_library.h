#pragma once

#include "tools/second_opinion/placed_pieces.h"

#include <array>
#include <functional>

namespace proximity_server::tools {

/// The answer of another library about two links or objects.
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

/// Asks another library about a pair. It may throw, abort or never end, so it is called in a child process.
using AskOther = std::function<OtherAnswer(const PlacedPieces& a, const PlacedPieces& b)>;

/// FCL, with the solver that it uses by default (libccd), over the same convex pieces; flat ones are triangles. The
/// distance of two bodies is the distance of their closest pieces, and the depth the depth of their deepest: both from
/// fcl::distance(), the depth with enable_signed_distance, and none where triangles overlap. Empty if this build has no
/// FCL.
AskOther makeFcl();

}  // namespace proximity_server::tools
