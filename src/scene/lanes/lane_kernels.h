#pragma once

// Included by sources that are compiled for newer processors than the rest of the program. So neither this nor what they
// include otherwise may bring an inline function or a template, of which the linker could keep the copy that an older
// processor does not understand.

namespace proximity_server::scene::lanes {

/// States that are placed at once. More of them fill the lanes better with those that a bound leaves, and need more cache.
constexpr int kBlock = 512;

/// Numbers of a pose, one row for each: the rotation row by row, then the translation.
constexpr int kPoseRows = 12;

using Row = float[kBlock];

/// Poses are kept in tiles of so many columns: all poses of a tile are side by side, each in kPoseRows rows. Whole rows of a
/// block would lie so far from each other that they push one another out of the first cache.
constexpr int kTile = 16;
using Tile = float[kPoseRows][kTile];
static_assert(kBlock % kTile == 0);

/// How a body stands on its parent: the rotation is fixed + sine * by_sine + cosine * by_cosine, the translation is
/// origin + position * slide.
struct BodyPlan {
  int parent;      ///< a number among the bodies before it; -1: the body does not move from the identity
  int turn;        ///< row of the angle; -1: the joint does not turn
  int slide;       ///< row of the position; -1: the joint does not slide
  float fixed[9];  ///< row by row, as all matrices
  float by_sine[9];
  float by_cosine[9];
  float origin[3];
  float direction[3];
};

/// The frame of a link, which is that of its box, on its body.
struct LinkPlan {
  int body;
  float rotation[9];
  float origin[3];
};

/// Points with the radii of the balls about them.
struct Balls {
  int count;
  const float* x;
  const float* y;
  const float* z;
  const float* radius;
};

/// The shapes of a pair, each in the frame of its link, and what is added to the errors of its bounds.
struct PairShapes {
  Balls outline_a, outline_b;  ///< the link is in the hull of these balls
  float uncovered;             ///< [m] that it may stick out of it, of both links
  float centre_a[3], centre_b[3];
  Balls inner_a, inner_b;  ///< contained in the link
  float half_a[3], half_b[3];
  bool is_exact;      ///< both links are convex, and contain the hull of the balls
  float box_error;    ///< [m] of the bounds of boxes
  float lower_error;  ///< [m] of the bounds along an axis
  float upper_error;  ///< [m] of the upper bounds
};

/// Pairs of frames, one in each column: the pose of link b in the frame of link a, the point of the CSO that the search has
/// reached, and the bounds.
struct alignas(64) Items {
  Row pose[kPoseRows];
  Row way[3];
  Row lower, upper;
};

/// Loops over the lanes, compiled for one kind of processor. Counts need not be multiples of the lanes: rows have room up to
/// kBlock, and what is there beyond the count is read and written, but does not matter. All give the same bits.
struct Kernels {
  const char* name;

  /// Sines and cosines of angles [rad] up to kMostAngle in `count` columns, within kSineError.
  void (*turn)(const double* angles, int count, float* sines, float* cosines);

  /// Poses of the bodies and of the links in `count` columns; one tile for each, then those of the next columns.
  void (*place)(const BodyPlan* bodies, int body_count, const LinkPlan* links, int link_count, int count,
                const Row* sines, const Row* cosines, const Row* positions, Tile* body_poses, Tile* link_poses);

  /// Sets near[i] to 0 where the square of the distance of the origins of two links is above a limit, else to 1.
  void (*far)(const Tile* pose_a, const Tile* pose_b, int link_count, int count, float limit, unsigned char* near);

  /// Fills the items with the relative poses of the two links in the columns listed, with the lower bound of their boxes, and
  /// without upper bound.
  void (*relate)(const Tile* pose_a, const Tile* pose_b, int link_count, const int* columns, int count,
                 const PairShapes& shapes, Items& items);

  /// Raises the lower bounds, and lowers the upper ones, by steps towards the point of the CSO nearest to the origin, with the
  /// first balls of both outlines only. Ends early where each lower bound is above a limit, or the upper one not above another. `way` has to be in the CSO.
  void (*search)(const PairShapes& shapes, int balls_a, int balls_b, float uncovered, int steps, float above,
                 float below, int count, Items& items);

  /// Lowers the upper bounds by inner balls that lie along the way.
  void (*meet)(const PairShapes& shapes, int count, Items& items);
};

constexpr double kMostAngle = 1e5;     ///< [rad]
constexpr double kSineError = 1.5e-7;  ///< tested
constexpr int kMostSteps = 32;         ///< of all searches of an item together, to which the upper error belongs

/// The best that this processor can do.
const Kernels& kernels();

/// All that this processor can do, the best first; nullptr ends them.
const Kernels* const* allKernels();

const Kernels& baselineKernels();
#ifdef __x86_64__
const Kernels& avx2Kernels();
const Kernels& avx512Kernels();
#endif

}  // namespace proximity_server::scene::lanes
