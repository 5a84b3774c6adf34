#pragma once

// This file is included by sources that are compiled for newer processors than the rest of the program. So neither this
// file nor the others that those sources include may define an inline function or a template: the linker could keep a
// copy of it that older processors cannot run.

namespace proximity_server::scene::lanes {

/// The number of states that are placed at once. A larger block fills the lanes better after bounds have excluded
/// states, but needs more cache.
constexpr int kBlock = 512;

/// The numbers of a pose, each in a row of its own: the rotation row by row, then the translation.
constexpr int kPoseRows = 12;

using Row = float[kBlock];
using WideRow = double[kBlock];

/// Poses are kept in tiles of this many columns. All poses of a tile are side by side, each in kPoseRows rows. Rows of
/// a whole block would be so far apart in memory that they push each other out of the first-level cache.
constexpr int kTile = 16;
using Tile = float[kPoseRows][kTile];
using WideTile = double[kPoseRows][kTile];
static_assert(kBlock % kTile == 0);

/// The pose of a body on its parent: the rotation is fixed + sine * by_sine + cosine * by_cosine, the translation is
/// origin + position * direction.
struct BodyPlan {
  int parent;        ///< number of an earlier body; -1: the body is fixed at the identity
  int angle_row;     ///< row of the angle; -1: the joint does not turn
  int position_row;  ///< row of the position; -1: the joint does not slide
  double fixed[9];   ///< row by row, like all matrices
  double by_sine[9];
  double by_cosine[9];
  double origin[3];
  double direction[3];
};

/// The frame of a link, which is the frame of its box, on its body.
struct LinkPlan {
  int body;
  double rotation[9];
  double origin[3];
};

/// Balls: their centres and radii.
struct Balls {
  int count;
  const float* x;
  const float* y;
  const float* z;
  const float* radius;
};

/// The shapes of a pair, each in the frame of its link, and the errors of its bounds.
struct PairShapes {
  Balls outline_a, outline_b;  ///< the link is in the hull of these balls
  float uncovered;             ///< [m] how far both links together may stick out of these hulls
  float centre_a[3], centre_b[3];
  Balls inner_a, inner_b;  ///< each ball is contained in the link
  float half_a[3], half_b[3];
  bool is_exact;      ///< both links are convex, and contain the hull of the balls
  float box_error;    ///< [m] of the bounds of boxes
  float lower_error;  ///< [m] of the bounds along an axis
  float upper_error;  ///< [m] of the upper bounds
};

/// Pairs of frames, one in each column: the pose of link b in the frame of link a, the point of the Minkowski
/// difference that the search has reached, and the bounds.
struct alignas(64) Items {
  Row pose[kPoseRows];
  Row cso_point[3];
  Row lower, upper;
};

/// Boxes along the axes of the frame of their link.
struct Boxes {
  int count;
  const float* centre[3];
  const float* half[3];
};

/// Two convex cores: the hulls of the centres of balls, each in the frame of its link. The radii are not read.
struct Cores {
  Balls a, b;
  float error;  ///< [m] of a bound along an axis, and of the length of a point of the CSO
};

/// The numbers of a leaf, each in a row of its own: the centre of its sphere and of its box, the half edges of the box,
/// its axes, which are the columns of a matrix, and the radius of the sphere.
constexpr int kLeafCentre = 0, kLeafHalf = 3, kLeafAxes = 6, kLeafRadius = 15, kLeafRows = 16;
constexpr int kMostLeaves = 64;
constexpr int kMostLanes = 16;

/// The leaves of a part of a scene, in a frame with the axes of their body and its origin near them. The number of leaf i
/// in a row is values[row * stride + i]. kMostLanes numbers behind the last one are read without effect.
struct Leaves {
  int count, stride;
  const float* values;
  float low[3], high[3];  ///< the bounding box of their boxes
};

/// A lower bound [m] of the distance of two leaves.
struct LeafGap {
  float lower_bound;
  int a, b;
};

struct FoundLeafGaps {
  int count;
  float smallest_of_others;  ///< [m] a lower bound of the distances of all pairs that were not written
};

/// The bodies of a robot, and the place of their poses: one tile for each, then the tiles of the next columns.
struct Bodies {
  const BodyPlan* plans;
  int count;
  WideTile* poses;
};

/// The links of a robot, and where their poses go.
struct Links {
  const LinkPlan* plans;
  int count;
  Tile* poses;
};

/// The ball about the origin of a link that contains it.
struct LinkBall {
  float radius;  ///< [m]
  float error;   ///< [m] of a bound of its motion between two columns
};

/// The poses of two links.
struct PairPoses {
  const Tile *a, *b;  ///< of the first columns
  int stride;         ///< the number of tiles to the poses of the next columns
};

/// The work of a search: how many balls of the outlines it takes, and how many steps it makes.
struct SearchEffort {
  int balls_a, balls_b;  ///< the number of balls at the begin of each outline
  float uncovered;       ///< [m] that both links together may stick out of them
  int steps;             ///< the largest number of steps
};

/// [m] A search is over where the lower bound is above the one limit, or the upper bound not above the other.
struct SearchLimits {
  float above, below;
};

/// Loops over the lanes, compiled for one kind of processor. Counts need not be multiples of the number of lanes: rows
/// have room for kBlock columns, and columns beyond the count are read and written without effect on the results. All
/// kernels give the same bits.
struct Kernels {
  const char* name;

  /// Computes sines and cosines of angles [rad] up to kMostAngle in `count` columns, within kSineError.
  void (*sinesAndCosines)(const double* angles, int count, double* sines, double* cosines);

  /// Poses of the bodies and of the links in `count` columns, computed in double. Those of the links are then rounded.
  void (*placeBodiesAndLinks)(const Bodies& bodies, const Links& links, int count, const WideRow* sines,
                              const WideRow* cosines, const WideRow* positions);

  /// Sums of upper bounds [m] of how far each ball moves from one column to the next one, from the first column on:
  /// travel[column * links + link].
  void (*travel)(const Tile* poses, int links, const LinkBall* balls, int count, double* travel);

  /// Sets near[i] to 0 if the squared distance of the origins of two links is above a limit, otherwise to 1.
  void (*markNear)(const PairPoses& poses, int count, float limit, unsigned char* near);

  /// Lists the columns in which the distance of the origins of two links is not above reach + limits[column] [m].
  /// Returns how many they are. Both arrays have kBlock entries.
  int (*findNear)(const PairPoses& poses, int count, double reach, const double* limits, int* columns);

  /// Fills the items with the relative poses of the two links in the columns listed, with the lower bound of their
  /// boxes, and without upper bound.
  void (*relativePoses)(const PairPoses& poses, const int* columns, int count, const PairShapes& shapes, Items& items);

  /// Raises the lower bounds, and lowers the upper ones, by steps towards the point of the CSO nearest to the origin.
  /// Ends early where the search of each item is over. `cso_point` has to be in the CSO.
  void (*boundByOutlines)(const PairShapes& shapes, const SearchEffort& effort, const SearchLimits& limits, int count,
                          Items& items);

  /// Lower bounds of the distances of all boxes of two links in the first `count` items. That of the boxes i and j in
  /// item k is gaps[(i * b.count + j) * stride + k]. At most kMostBoxes boxes for each link.
  void (*boxGaps)(const Boxes& a, const Boxes& b, float error, int count, const Items& items, int stride, float* gaps);

  /// Bounds the signed distance of two cores in the listed columns of the items by GJK. Each search begins along the
  /// point of the CSO of the item, which need not be one of these cores. It ends where the lower
  /// bound is above its limit, or the width of the bounds is at most `accuracy` [m], or where rounding allows no
  /// further step. An overlap that is proven has the upper bound 0.
  void (*boundByGjk)(const Cores& cores, float accuracy, const Items& items, const int* columns, const float* limits,
                     int count, float* lower, float* upper);

  /// Lowers the upper bounds by inner balls near the last points of the search.
  void (*boundByInnerBalls)(const PairShapes& shapes, int count, Items& items);

  /// Bounds the distances of all pairs of leaves of two parts by spheres, then by boxes. `a_T_b` are the numbers of a
  /// pose. Writes the pairs whose bound is not above the limit [m], in any order. LeafGaps derives the rounding error.
  FoundLeafGaps (*leafGaps)(const Leaves& a, const Leaves& b, const float* a_T_b, float limit, LeafGap* gaps);
};

constexpr double kMostAngle = 1e5;    ///< [rad]
constexpr double kSineError = 3e-16;  ///< tested
constexpr int kMostSteps = 32;        ///< the sum over all searches of an item; the upper error depends on it
constexpr int kMostBoxes = 64;

/// The best kernels for this processor.
const Kernels& kernels();

/// All kernels for this processor, the best first, then nullptr.
const Kernels* const* allKernels();

const Kernels& baselineKernels();
#ifdef __x86_64__
const Kernels& avx2Kernels();
const Kernels& avx512Kernels();
#endif

}  // namespace proximity_server::scene::lanes
