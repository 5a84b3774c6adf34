// The loops of lane_kernels.h, for a processor with PROXIMITY_LANES lanes of float, see lane_vectors.h.

#include "scene/bounds/lane_vectors.h"
#include "scene/lanes/lane_kernels.h"

namespace proximity_server::scene::lanes {
namespace {

Float load(const float* row) { return *reinterpret_cast<const Float*>(row); }
void store(Float value, float* row) { *reinterpret_cast<Float*>(row) = value; }

Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Point operator*(Float s, const Point& a) { return {s * a.x, s * a.y, s * a.z}; }
Point choose(Int mask, const Point& a, const Point& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
Point point(const float* p) { return {all(p[0]), all(p[1]), all(p[2])}; }
Point ball(const Balls& balls, int i) { return {all(balls.x[i]), all(balls.y[i]), all(balls.z[i])}; }

struct Pose {
  Float rotation[9];
  Point origin;
};

Point turned(const Float* rotation, const Point& p) {
  return {(rotation[0] * p.x + rotation[1] * p.y) + rotation[2] * p.z,
          (rotation[3] * p.x + rotation[4] * p.y) + rotation[5] * p.z,
          (rotation[6] * p.x + rotation[7] * p.y) + rotation[8] * p.z};
}
Point turnedBack(const Float* rotation, const Point& p) {
  return {(rotation[0] * p.x + rotation[3] * p.y) + rotation[6] * p.z,
          (rotation[1] * p.x + rotation[4] * p.y) + rotation[7] * p.z,
          (rotation[2] * p.x + rotation[5] * p.y) + rotation[8] * p.z};
}

/// Loads a pose from 12 rows.
template <typename Rows>
Pose loadPose(const Rows& rows, int column) {
  Pose pose;
  for (int k = 0; k < 9; ++k) pose.rotation[k] = load(rows[k] + column);
  pose.origin = {load(rows[9] + column), load(rows[10] + column), load(rows[11] + column)};
  return pose;
}

template <typename Rows>
void storePose(const Pose& pose, Rows& rows, int column) {
  for (int k = 0; k < 9; ++k) store(pose.rotation[k], rows[k] + column);
  store(pose.origin.x, rows[9] + column);
  store(pose.origin.y, rows[10] + column);
  store(pose.origin.z, rows[11] + column);
}

/// The pose of a frame that has this rotation and origin on its parent.
Pose stacked(const Pose& parent, const Float* rotation, const Point& origin) {
  Pose pose;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      pose.rotation[3 * row + column] =
          (parent.rotation[3 * row] * rotation[column] + parent.rotation[3 * row + 1] * rotation[3 + column]) +
          parent.rotation[3 * row + 2] * rotation[6 + column];
  pose.origin = parent.origin + turned(parent.rotation, origin);
  return pose;
}

// --- kinematics

/// Subtracts the nearest multiple of a quarter turn from each angle. The quarter turn has two parts, the first with 33
/// bits, so that its product with the number of quarters is exact. Then evaluates Taylor's polynomials up to pi / 4,
/// whose remainder is below 2e-9.
void sinesAndCosines(const double* angles, int count, float* sines, float* cosines) {
  constexpr double kQuartersPerRadian = 0.63661977236758138;
  constexpr double kQuarter = 1.5707963267341256, kRestOfQuarter = 6.0771005065061922e-11;
  constexpr double kRounds = 6755399441055744.0;  // 1.5 * 2^52: a sum with it is a whole number
  alignas(64) float rests[kBlock];
  alignas(64) int quarters[kBlock];
  for (int i = 0; i < count; ++i) {
    const double quarter = (angles[i] * kQuartersPerRadian + kRounds) - kRounds;
    rests[i] = static_cast<float>((angles[i] - quarter * kQuarter) - quarter * kRestOfQuarter);
    quarters[i] = static_cast<int>(quarter);
  }
  for (int i = 0; i < count; i += kLanes) {
    const Float r = load(rests + i), z = r * r;
    const Int quarter = *reinterpret_cast<const Int*>(quarters + i);
    const Float sine =
        r + r * (z * (z * (z * (z * (1.0f / 362880.0f) - 1.0f / 5040.0f) + 1.0f / 120.0f) - 1.0f / 6.0f));
    const Float cosine =
        1.0f + z * (z * (z * (z * (1.0f / 40320.0f - z * (1.0f / 3628800.0f)) - 1.0f / 720.0f) + 1.0f / 24.0f) - 0.5f);
    const Int is_odd = (quarter & 1) != 0;
    const Int sign_of_sine = (quarter & 2) << 30, sign_of_cosine = ((quarter + 1) & 2) << 30;
    store(reinterpret_cast<Float>(reinterpret_cast<Int>(is_odd ? cosine : sine) ^ sign_of_sine), sines + i);
    store(reinterpret_cast<Float>(reinterpret_cast<Int>(is_odd ? sine : cosine) ^ sign_of_cosine), cosines + i);
  }
}

/// `tile` has the poses of the bodies before this one.
Pose placed(const BodyPlan& body, int column, const Row* sines, const Row* cosines, const Row* positions,
            const Tile* tile) {
  Float rotation[9];
  for (int k = 0; k < 9; ++k) rotation[k] = all(body.fixed[k]);
  Point origin = point(body.origin);
  if (body.angle_row >= 0) {
    const Float sine = load(sines[body.angle_row] + column), cosine = load(cosines[body.angle_row] + column);
    for (int k = 0; k < 9; ++k) rotation[k] = (rotation[k] + sine * body.by_sine[k]) + cosine * body.by_cosine[k];
  }
  if (body.position_row >= 0) origin = origin + load(positions[body.position_row] + column) * point(body.direction);
  if (body.parent >= 0) return stacked(loadPose(tile[body.parent], column % kTile), rotation, origin);
  Pose pose;
  for (int k = 0; k < 9; ++k) pose.rotation[k] = rotation[k];
  pose.origin = origin;
  return pose;
}

void placeBodiesAndLinks(const Bodies& bodies, const Links& links, int count, const Row* sines, const Row* cosines,
                         const Row* positions) {
  for (int column = 0; column < count; column += kLanes) {
    Tile* const body_tile = bodies.poses + column / kTile * bodies.count;
    Tile* const link_tile = links.poses + column / kTile * links.count;
    for (int i = 0; i < bodies.count; ++i)
      storePose(placed(bodies.plans[i], column, sines, cosines, positions, body_tile), body_tile[i], column % kTile);
    for (int i = 0; i < links.count; ++i) {
      const LinkPlan& link = links.plans[i];
      Float rotation[9];
      for (int k = 0; k < 9; ++k) rotation[k] = all(link.rotation[k]);
      const Pose body = loadPose(body_tile[link.body], column % kTile);
      storePose(stacked(body, rotation, point(link.origin)), link_tile[i], column % kTile);
    }
  }
}

// --- bounds

void markNear(const PairPoses& poses, int count, float limit, unsigned char* near) {
  const Tile *pose_a = poses.a, *pose_b = poses.b;
  for (int first = 0; first < count; first += kTile, pose_a += poses.stride, pose_b += poses.stride) {
    const Tile &a = *pose_a, &b = *pose_b;
    for (int i = 0; i < kTile; ++i) {
      const float x = b[9][i] - a[9][i], y = b[10][i] - a[10][i], z = b[11][i] - a[11][i];
      near[first + i] = static_cast<unsigned char>(!((x * x + y * y) + z * z > limit));
    }
  }
}

/// A lower bound of the distance of the boxes of two links.
Float boxGap(const Pose& a_T_b, const PairShapes& shapes) {
  const Point in_b = turnedBack(a_T_b.rotation, a_T_b.origin);
  const Float offset_in_a[3] = {a_T_b.origin.x, a_T_b.origin.y, a_T_b.origin.z},
              offset_in_b[3] = {in_b.x, in_b.y, in_b.z};
  return boxGap(a_T_b.rotation, offset_in_a, offset_in_b, shapes.half_a, shapes.half_b, shapes.box_error) -
         shapes.box_error;
}

void relativePoses(const PairPoses& poses, const int* columns, int count, const PairShapes& shapes, Items& items) {
  for (int first = 0; first < count; first += kLanes) {
    alignas(64) float gathered[2 * kPoseRows][kLanes];
    const int filled = count - first < kLanes ? count - first : kLanes;
    for (int i = 0; i < kLanes; ++i) {
      const int column = columns[first + (i < filled ? i : 0)];
      const int place = column / kTile * poses.stride;
      const Tile &tile_a = poses.a[place], &tile_b = poses.b[place];
      for (int k = 0; k < kPoseRows; ++k) {
        gathered[k][i] = tile_a[k][column % kTile];
        gathered[kPoseRows + k][i] = tile_b[k][column % kTile];
      }
    }
    Float a[kPoseRows], b[kPoseRows];
    for (int k = 0; k < kPoseRows; ++k) {
      a[k] = load(gathered[k]);
      b[k] = load(gathered[kPoseRows + k]);
    }
    Pose a_T_b;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        a_T_b.rotation[3 * row + column] =
            (a[row] * b[column] + a[3 + row] * b[3 + column]) + a[6 + row] * b[6 + column];
    a_T_b.origin = turnedBack(a, Point{b[9], b[10], b[11]} - Point{a[9], a[10], a[11]});
    storePose(a_T_b, items.pose, first);
    store(boxGap(a_T_b, shapes), items.lower + first);
    store(all(__builtin_inff()), items.upper + first);
    const Point cso_point = point(shapes.centre_a) - (a_T_b.origin + turned(a_T_b.rotation, point(shapes.centre_b)));
    store(cso_point.x, items.cso_point[0] + first);
    store(cso_point.y, items.cso_point[1] + first);
    store(cso_point.z, items.cso_point[2] + first);
  }
}

/// The point of the balls that is farthest in a unit direction, and its height along the direction.
struct Support {
  Float height;
  Point point;
};
Support support(const Balls& balls, int count, const Point& direction) {
  Support best{all(-__builtin_inff()), {}};
  Float radius = all(0.0f);
  for (int i = 0; i < count; ++i) {
    const Point centre = ball(balls, i);
    const Float height = dot(centre, direction) + balls.radius[i];
    const Int is_higher = height > best.height;
    best.height = is_higher ? height : best.height;
    best.point = choose(is_higher, centre, best.point);
    radius = is_higher ? all(balls.radius[i]) : radius;
  }
  best.point = best.point + radius * direction;
  return best;
}

void boundByOutlines(const PairShapes& shapes, const SearchEffort& effort, const SearchLimits& limits, int count,
                     Items& items) {
  const Float zero = all(0.0f), one = all(1.0f);
  const Float infinity = all(__builtin_inff());
  for (int first = 0; first < count; first += kLanes) {
    const Pose a_T_b = loadPose(items.pose, first);
    Point cso_point{load(items.cso_point[0] + first), load(items.cso_point[1] + first),
                    load(items.cso_point[2] + first)};
    Float lower = load(items.lower + first), upper = load(items.upper + first);
    for (int step = 0; step < effort.steps; ++step) {
      const Float square = dot(cso_point, cso_point);
      // If the point is nearer to the origin, rounding makes its direction useless.
      const Int has_direction = square > all(1e-12f);
      const Float length = root(has_direction ? square : one);
      if (shapes.is_exact) upper = smaller(upper, (has_direction ? length : all(1e-6f)) + shapes.upper_error);
      const Point direction = (-1.0f / length) * cso_point;  // points from a to b
      const Point in_b = turnedBack(a_T_b.rotation, direction);
      const Support a = support(shapes.outline_a, effort.balls_a, direction);
      const Support b = support(shapes.outline_b, effort.balls_b, Point{-in_b.x, -in_b.y, -in_b.z});
      const Float gap =
          ((dot(direction, a_T_b.origin) - b.height) - a.height) - (effort.uncovered + shapes.lower_error);
      lower = larger(lower, has_direction ? gap : -infinity);
      if (!any(~((lower > all(limits.above)) | (upper <= all(limits.below))))) break;
      const Point farthest = a.point - (a_T_b.origin + turned(a_T_b.rotation, b.point));
      const Point step_towards = farthest - cso_point;
      const Float part = -dot(cso_point, step_towards) / larger(dot(step_towards, step_towards), all(1e-20f));
      cso_point = cso_point + smaller(larger(part, zero), one) * step_towards;
    }
    store(cso_point.x, items.cso_point[0] + first);
    store(cso_point.y, items.cso_point[1] + first);
    store(cso_point.z, items.cso_point[2] + first);
    store(lower, items.lower + first);
    store(upper, items.upper + first);
  }
}

/// The ball that is nearest to a point, and the distance of its surface.
struct NearestBall {
  Float gap, radius;
  Point centre;
};
NearestBall nearest(const Balls& balls, const Point& p) {
  NearestBall best{all(__builtin_inff()), all(0.0f), {}};
  for (int i = 0; i < balls.count; ++i) {
    const Point centre = ball(balls, i), between = centre - p;
    const Float gap = root(dot(between, between)) - balls.radius[i];
    const Int is_nearer = gap < best.gap;
    best.gap = is_nearer ? gap : best.gap;
    best.radius = is_nearer ? all(balls.radius[i]) : best.radius;
    best.centre = choose(is_nearer, centre, best.centre);
  }
  return best;
}

/// Begins at the ball of b that is farthest in the direction of the point of the CSO, so towards a. Goes to the nearest
/// ball of a, from there to the nearest ball of b, and repeats this once: each step shortens the distance.
void boundByInnerBalls(const PairShapes& shapes, int count, Items& items) {
  if (shapes.inner_a.count == 0 || shapes.inner_b.count == 0) return;
  for (int first = 0; first < count; first += kLanes) {
    const Pose a_T_b = loadPose(items.pose, first);
    const Point cso_point{load(items.cso_point[0] + first), load(items.cso_point[1] + first),
                          load(items.cso_point[2] + first)};
    const Float square = dot(cso_point, cso_point);
    const Float length = root(square > all(1e-12f) ? square : all(1.0f));
    const Point towards_a = (1.0f / length) * cso_point, in_b = turnedBack(a_T_b.rotation, towards_a);
    Point on_b = support(shapes.inner_b, shapes.inner_b.count, in_b).point;
    Float upper = load(items.upper + first);
    for (int round = 0; round < 2; ++round) {
      const NearestBall a = nearest(shapes.inner_a, a_T_b.origin + turned(a_T_b.rotation, on_b));
      const NearestBall b = nearest(shapes.inner_b, turnedBack(a_T_b.rotation, a.centre - a_T_b.origin));
      upper = smaller(upper, (b.gap - a.radius) + shapes.upper_error);
      on_b = b.centre;
    }
    store(upper, items.upper + first);
  }
}

}  // namespace
}  // namespace proximity_server::scene::lanes
