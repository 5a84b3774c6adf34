#pragma once

#include "oracle/shape_pairs.h"
#include "tools/second_opinion/placed_pieces.h"

namespace proximity_server::tools {

/// Two bodies of one piece each.
class SinglePieces {
 public:
  explicit SinglePieces(const narrowphase::PairCase& pair)
      : piece_a_{pair.a, Eigen::Isometry3d::Identity(), 0},
        piece_b_{pair.b, Eigen::Isometry3d::Identity(), 0},
        a_T_b_(pair.a_T_b) {}

  PlacedPieces a() const { return {{{&piece_a_, Eigen::Isometry3d::Identity()}}}; }
  PlacedPieces b() const { return {{{&piece_b_, a_T_b_}}}; }

 private:
  scene::Piece piece_a_, piece_b_;
  Eigen::Isometry3d a_T_b_;
};

}  // namespace proximity_server::tools
