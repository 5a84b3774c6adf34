#pragma once

#include "scene/query/closest_pieces.h"

namespace proximity_server::scene {

/// True if interiors matter to the distance of two parts.
inline bool haveInterior(const Part& a, const Part& b) { return a.whole().has_interior || b.whole().has_interior; }

/// Finds how deep pieces of one part lie in the interiors of the other part, see Interior. The pieces of the two may be
/// apart there.
///
/// 1. The surface of an interior consists of pieces of its part. So, if no pieces meet, each connected component of a
///    part lies either wholly inside the interior of the other part or wholly outside; one representative of each
///    component tells which.
/// 2. Walk from each interior through the volumes of the other part to the representatives. Skip the volumes that are
///    outside of the box of the interior.
/// 3. The result for a representative is the signed distance from the solid of the ball at the centre of the
///    representative, see Shape::innerRadius(). No shorter translation takes the ball out of the solid, so the depth of
///    the whole is not less.
///
/// That distance changes by no more than the two parts move, and where it is 0 the pieces meet. So the smaller of it
/// and of the distance of the pieces may be kept and bounded by motion, like the distance of the pieces alone.
///
/// Offers to `closest`, in the frame of a, each result that is deeper than those it has and closer than `limit` [m]. A
/// result must also be closer than `within` [m] without the padding of the pair; `within` is 0, unless the two can
/// still move. The pair of leaves is the piece that has the interior, and the representative. One point is on the
/// surface of the interior, the other one in the other part.
///
/// `pieces`: the closest pieces of the two, if they are known. Then no depth is computed that is proven to be less than
/// theirs, and what is found with them is the same.
void findInteriorDepths(const PlacedPair& pair, double limit, const Question& question, Skipping skipping,
                        double within, ClosestPieces& closest, const ClosestPieces* pieces = nullptr);

}  // namespace proximity_server::scene
