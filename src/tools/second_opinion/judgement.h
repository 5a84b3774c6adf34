#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "tools/second_opinion/child_answers.h"
#include "tools/second_opinion/other_library.h"
#include "tools/second_opinion/placed_pieces.h"
#include "tools/second_opinion/proven_bounds.h"

namespace proximity_server::tools {

/// A ruling tells who is right about a pair, as far as it can be proven.
enum class Ruling : unsigned char {
  Agrees,      ///< the other value lies within our bounds and the tolerance
  NotAsked,    ///< the other library has no shape for one of the two
  BelowLower,  ///< the other value is below the proven lower bound
  AboveUpper,  ///< the other value is above the proven upper bound
  Failed,      ///< the other library threw, aborted, did not end, or said NaN
  Inside,      ///< ours says that one lies inside of a closed mesh, and no piece shows that
  Undecided,   ///< what is proven allows both
  OursRefuted  ///< what is proven contradicts the bounds of our answer
};

/// A sentence for people.
const char* toString(Ruling ruling);

/// The other library's answer about a pair.
struct OtherOpinion {
  ChildEnd end = ChildEnd::Answered;
  OtherAnswer answer;
};

/// A pair and what both say of it.
struct TwoOpinions {
  const PlacedPieces &a, &b;
  double padding;  ///< [m] taken off the distance of the pieces
  const narrowphase::SignedDistance& ours;
  const OtherOpinion& other;
};

struct Judgement {
  Ruling ruling = Ruling::Agrees;
  ProvenBounds proven{};  ///< only where the two differ
};

/// Decides who is right. If the two differ by more than the tolerance [m], the axes and points of both are put to the
/// proof (proven_bounds.h), and the values are held against what it proves.
///
/// An overlap of which the other library gives no depth is any value up to 0. A body inside of a closed mesh overlaps
/// what is between the pieces of the mesh: where ours is such an overlap, no axis of two pieces proves anything.
Judgement judge(const TwoOpinions& opinions, double tolerance);

}  // namespace proximity_server::tools
