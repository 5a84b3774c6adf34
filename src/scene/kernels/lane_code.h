// The loops of lane_kernels.h, for a processor with PROXIMITY_LANES lanes of float, see lane_vectors.h.

#include "scene/kernels/lane_kernels.h"
#include "scene/kernels/lane_vectors.h"

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

// --- kinematics, in loops of doubles that the compiler turns into lanes

/// Subtracts the nearest multiple of a quarter turn from each angle. The quarter turn has two parts, the first with 33
/// bits, so that its product with the number of quarters is exact. Then evaluates Taylor's polynomials up to pi / 4,
/// whose remainder is below 2e-16.
void sinesAndCosines(const double* angles, int count, double* sines, double* cosines) {
  constexpr double kQuartersPerRadian = 0.63661977236758138;
  constexpr double kQuarter = 1.5707963267341256, kRestOfQuarter = 6.0771005065061922e-11;
  constexpr double kRounds = 6755399441055744.0;  // 1.5 * 2^52: a sum with it is a whole number
  for (int i = 0; i < count; ++i) {
    const double quarter = (angles[i] * kQuartersPerRadian + kRounds) - kRounds;
    const double of_four = quarter - 4.0 * ((0.25 * quarter + kRounds) - kRounds);  // from -2 to 2
    const double r = (angles[i] - quarter * kQuarter) - quarter * kRestOfQuarter, z = r * r;
    const double sine =
        r + r * (z * (z * (z * (z * (z * (z * (z * (-1.0 / 1307674368000.0) + 1.0 / 6227020800.0) - 1.0 / 39916800.0) +
                                     1.0 / 362880.0) -
                                1.0 / 5040.0) +
                           1.0 / 120.0) -
                      1.0 / 6.0));
    const double cosine =
        1.0 +
        z * (z * (z * (z * (z * (z * (z * (z * (1.0 / 20922789888000.0) - 1.0 / 87178291200.0) + 1.0 / 479001600.0) -
                                 1.0 / 3628800.0) +
                            1.0 / 40320.0) -
                       1.0 / 720.0) +
                  1.0 / 24.0) -
             0.5);
    const bool is_odd = of_four == 1.0 || of_four == -1.0;
    const double for_sine = is_odd ? cosine : sine, for_cosine = is_odd ? sine : cosine;
    sines[i] = of_four == 0.0 || of_four == 1.0 ? for_sine : -for_sine;
    cosines[i] = of_four == 0.0 || of_four == -1.0 ? for_cosine : -for_cosine;
  }
}

/// Places frames with this rotation and origin on their parents, in the columns of a tile.
template <typename Rotation, typename Origin, typename Pose>
void stack(const WideTile& parent, const Rotation& rotation, const Origin& origin, Pose& pose) {
  for (int i = 0; i < 3; ++i) {
    const double *x = parent[3 * i], *y = parent[3 * i + 1], *z = parent[3 * i + 2], *o = parent[9 + i];
    for (int j = 0; j < 3; ++j)
      for (int c = 0; c < kTile; ++c)
        pose(3 * i + j, c, (x[c] * rotation(j, c) + y[c] * rotation(3 + j, c)) + z[c] * rotation(6 + j, c));
    for (int c = 0; c < kTile; ++c)
      pose(9 + i, c, o[c] + ((x[c] * origin(0, c) + y[c] * origin(1, c)) + z[c] * origin(2, c)));
  }
}

/// `tile` has the poses of the bodies before this one.
void placeBody(const BodyPlan& body, int column, const WideRow* sines, const WideRow* cosines, const WideRow* positions,
               const WideTile* tile, WideTile& pose) {
  WideTile on_parent;
  for (int k = 0; k < 9; ++k)
    for (int c = 0; c < kTile; ++c) on_parent[k][c] = body.fixed[k];
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < kTile; ++c) on_parent[9 + k][c] = body.origin[k];
  if (body.angle_row >= 0) {
    const double *sine = sines[body.angle_row] + column, *cosine = cosines[body.angle_row] + column;
    for (int k = 0; k < 9; ++k)
      for (int c = 0; c < kTile; ++c)
        on_parent[k][c] = (on_parent[k][c] + sine[c] * body.by_sine[k]) + cosine[c] * body.by_cosine[k];
  }
  if (body.position_row >= 0) {
    const double* position = positions[body.position_row] + column;
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < kTile; ++c) on_parent[9 + k][c] += position[c] * body.direction[k];
  }
  if (body.parent < 0) {
    for (int k = 0; k < kPoseRows; ++k)
      for (int c = 0; c < kTile; ++c) pose[k][c] = on_parent[k][c];
    return;
  }
  const auto set = [&](int row, int c, double value) { pose[row][c] = value; };
  stack(
      tile[body.parent], [&](int k, int c) { return on_parent[k][c]; },
      [&](int k, int c) { return on_parent[9 + k][c]; }, set);
}

void placeBodiesAndLinks(const Bodies& bodies, const Links& links, int count, const WideRow* sines,
                         const WideRow* cosines, const WideRow* positions) {
  for (int column = 0; column < count; column += kTile) {
    WideTile* const body_tile = bodies.poses + column / kTile * bodies.count;
    Tile* const link_tile = links.poses + column / kTile * links.count;
    for (int i = 0; i < bodies.count; ++i)
      placeBody(bodies.plans[i], column, sines, cosines, positions, body_tile, body_tile[i]);
    for (int i = 0; i < links.count; ++i) {
      const LinkPlan& link = links.plans[i];
      Tile& pose = link_tile[i];
      const auto set = [&](int row, int c, double value) { pose[row][c] = static_cast<float>(value); };
      stack(
          body_tile[link.body], [&](int k, int) { return link.rotation[k]; },
          [&](int k, int) { return link.origin[k]; }, set);
    }
  }
}

// --- bounds

/// A point of a ball moves at most as far as its centre, and as a vector of its radius turns: the difference of two
/// rotations stretches it by at most the norm of the difference / sqrt(2).
void travel(const Tile* poses, int links, const LinkBall* balls, int count, double* travel) {
  for (int link = 0; link < links; ++link) {
    const float turns = 0.70711f * balls[link].radius;
    float last[kPoseRows];
    for (int k = 0; k < kPoseRows; ++k) last[k] = poses[link][k][0];
    double sum = 0.0;
    for (int first = 0; first < count; first += kTile) {
      const Tile& now = poses[first / kTile * links + link];
      alignas(64) float before[kPoseRows][kTile], steps[kTile];
      for (int k = 0; k < kPoseRows; ++k) {
        before[k][0] = last[k];
        for (int i = 1; i < kTile; ++i) before[k][i] = now[k][i - 1];
        last[k] = now[k][kTile - 1];
      }
      for (int i = 0; i < kTile; i += kLanes) {
        Float squares[2] = {};  // of the rotation, of the origin
        for (int k = 0; k < kPoseRows; ++k) {
          const Float change = load(now[k] + i) - load(before[k] + i);
          squares[k / 9] = squares[k / 9] + change * change;
        }
        // 1.00001 is more than all rounding
        store(1.00001f * (root(squares[1]) + turns * root(squares[0])) + balls[link].error, steps + i);
      }
      for (int i = 0; i < kTile && first + i < count; ++i) {
        sum += static_cast<double>(steps[i]);
        travel[(first + i) * links + link] = sum;
      }
    }
  }
}

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

int findNear(const PairPoses& poses, int count, double reach, const double* limits, int* columns) {
  const Tile *pose_a = poses.a, *pose_b = poses.b;
  int found = 0;
  for (int first = 0; first < count; first += kTile, pose_a += poses.stride, pose_b += poses.stride) {
    const Tile &a = *pose_a, &b = *pose_b;
    // The square of a distance in float has a relative error of 2 u from the differences and of 4 u from products and
    // sums; the square of a limit is rounded to float.
    alignas(64) float squares[kTile];
    for (int i = 0; i < kTile; ++i) {
      const double within = reach + limits[first + i];
      squares[i] = within < 0.0 ? -1.0f : static_cast<float>(within * within * (1.0 + 0x1p-19));
    }
    for (int i = 0; i < kTile; i += kLanes) {
      const Point between{load(b[9] + i) - load(a[9] + i), load(b[10] + i) - load(a[10] + i),
                          load(b[11] + i) - load(a[11] + i)};
      const Int is_near = ~(dot(between, between) > load(squares + i));
      if (!any(is_near)) continue;
      for (int k = 0; k < kLanes && first + i + k < count; ++k) {
        columns[found] = first + i + k;
        found -= is_near[k];
      }
    }
  }
  return found;
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

// --- pieces

void boxGaps(const Boxes& a, const Boxes& b, float error, int count, const Items& items, int stride, float* gaps) {
  struct Placed {  // a box in the frame of the other link: its centre, and the half of its bounding box there
    Float centre[3], half[3];
  };
  for (int first = 0; first < count; first += kLanes) {
    const Pose a_T_b = loadPose(items.pose, first);
    Placed in_b[kMostBoxes];
    for (int i = 0; i < a.count; ++i) {
      const Point p = turnedBack(a_T_b.rotation, Point{a.centre[0][i] - a_T_b.origin.x, a.centre[1][i] - a_T_b.origin.y,
                                                       a.centre[2][i] - a_T_b.origin.z});
      in_b[i].centre[0] = p.x, in_b[i].centre[1] = p.y, in_b[i].centre[2] = p.z;
      for (int k = 0; k < 3; ++k)
        in_b[i].half[k] =
            (absolute(a_T_b.rotation[k]) * a.half[0][i] + absolute(a_T_b.rotation[3 + k]) * a.half[1][i]) +
            absolute(a_T_b.rotation[6 + k]) * a.half[2][i];
    }
    for (int j = 0; j < b.count; ++j) {
      const Point p =
          a_T_b.origin + turned(a_T_b.rotation, Point{all(b.centre[0][j]), all(b.centre[1][j]), all(b.centre[2][j])});
      const Float in_a[3] = {p.x, p.y, p.z};
      Float half[3];
      for (int k = 0; k < 3; ++k)
        half[k] =
            (absolute(a_T_b.rotation[3 * k]) * b.half[0][j] + absolute(a_T_b.rotation[3 * k + 1]) * b.half[1][j]) +
            absolute(a_T_b.rotation[3 * k + 2]) * b.half[2][j];
      for (int i = 0; i < a.count; ++i) {
        Float along_a[3], along_b[3];
        for (int k = 0; k < 3; ++k) {
          along_a[k] = ((absolute(in_a[k] - a.centre[k][i]) - a.half[k][i]) - half[k]) - error;
          along_b[k] = ((absolute(in_b[i].centre[k] - b.centre[k][j]) - b.half[k][j]) - in_b[i].half[k]) - error;
        }
        store(larger(fromBox(along_a), fromBox(along_b)) - error, gaps + (i * b.count + j) * stride + first);
      }
    }
  }
}

Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The core's vertex that is farthest in a direction.
Support vertex(const Balls& core, const Point& direction) {
  Float highest = all(-__builtin_inff());
  Int place{};
  for (int i = 0; i < core.count; ++i) {
    const Float height = dot(ball(core, i), direction);
    place = height > highest ? Int{} + i : place;
    highest = larger(height, highest);
  }
  Point farthest;
  for (int k = 0; k < kLanes; ++k) {
    farthest.x[k] = core.x[place[k]];
    farthest.y[k] = core.y[place[k]];
    farthest.z[k] = core.z[place[k]];
  }
  return {highest, farthest};
}

/// The point nearest to the origin on those edges and faces of a tetrahedron that contain its newest vertex.
struct Nearest {
  Point point;        ///< a combination of the vertices whose weights are in [0, 1]
  Float square;       ///< of its length
  Point direction;    ///< the direction of the point; of a face its normal, which is more exact near contact
  Int first, second;  ///< the numbers of the other vertices of the edge or face; they repeat for a vertex or an edge
  Int is_inside;      ///< the origin is on the inner side of the three faces
};

// With fused or rounded products the cross product of two nearly parallel edges has no direction.
constexpr float kFlat = 1e-8f;  ///< of the squared sine of the angle of a face

Nearest nearest(const Point* simplex, const Point& newest) {
  Point edges[3], normals[3];
  for (int i = 0; i < 3; ++i) edges[i] = simplex[i] - newest;
  Nearest best{newest, all(__builtin_inff()), newest, Int{}, Int{}, ~Int{}};
  Float squares[3];
  for (int i = 0; i < 3; ++i) {
    squares[i] = dot(edges[i], edges[i]);
    const Float part = -dot(newest, edges[i]) / larger(squares[i], all(1e-37f));
    const Point p = newest + smaller(larger(part, all(0.0f)), all(1.0f)) * edges[i];
    const Float square = dot(p, p);
    const Int is_nearer = square < best.square;
    best.square = is_nearer ? square : best.square;
    best.point = choose(is_nearer, p, best.point);
    best.first = is_nearer ? Int{} + i : best.first;
  }
  best.second = best.first;
  best.direction = best.point;
  Float heights[3];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    normals[i] = cross(edges[i], edges[j]);
    heights[i] = dot(normals[i], newest);
    const Float area2 = dot(normals[i], normals[i]);
    const Float of_i = dot(normals[i], cross(edges[j], newest)), of_j = dot(normals[i], cross(newest, edges[i]));
    const Int is_solid = area2 > kFlat * (squares[i] * squares[j]);
    best.is_inside = best.is_inside & is_solid;
    const Int is_over = is_solid & (of_i >= 0.0f) & (of_j >= 0.0f) & (of_i + of_j <= area2);
    const Float per_area = 1.0f / (is_solid ? area2 : all(1.0f));
    const Point p = newest + ((of_i * per_area) * edges[i] + (of_j * per_area) * edges[j]);
    const Float square = dot(p, p);
    const Int is_nearer = is_over & (square < best.square);
    best.square = is_nearer ? square : best.square;
    best.point = choose(is_nearer, p, best.point);
    const Float sign = heights[i] < 0.0f ? all(-1.0f) : all(1.0f);
    best.direction = choose(is_nearer, sign * normals[i], best.direction);
    best.first = is_nearer ? Int{} + i : best.first;
    best.second = is_nearer ? Int{} + j : best.second;
  }
  const Float volume = dot(normals[0], edges[2]);
  for (int i = 0; i < 3; ++i) best.is_inside = best.is_inside & (heights[i] * volume < 0.0f);
  return best;
}

/// Tells in which lanes the origin lies inside of a tetrahedron, deeper than `error` [m] below each face.
Int isDeepInside(const Point* corners, float error) {
  Int is_inside = ~Int{};
  for (int i = 0; i < 4; ++i) {
    const Point &p = corners[i], u = corners[(i + 1) % 4] - p, v = corners[(i + 2) % 4] - p;
    const Point normal = cross(u, v);
    const Float height = dot(normal, p), opposite = dot(normal, corners[(i + 3) % 4] - p);
    // 16 u: the rounding of the normal, and of the height
    const Float rounding = 1e-6f * root((dot(u, u) * dot(v, v)) * dot(p, p));
    is_inside = is_inside & ((height < 0.0f) == (opposite > 0.0f)) &
                (absolute(height) > error * root(dot(normal, normal)) + rounding);
  }
  return is_inside;
}

// A lane whose search has ended takes the next column, as soon as some have ended: so nearly all lanes work. The
// simplex has always three vertices, which may be equal; what is degenerate is never the nearest. So there is one path
// for all dimensions.
void boundByGjk(const Cores& cores, float accuracy, const Items& items, const int* columns, const float* limits,
                int count, float* lower_bounds, float* upper_bounds) {
  constexpr int kSteps = 32, kRefill = kLanes / 8 + 1;
  const Float infinity = all(__builtin_inff());
  alignas(64) float taken[kPoseRows + 4][kLanes] = {};
  alignas(64) int is_fresh[kLanes];
  int item[kLanes];
  bool is_idle[kLanes];
  for (int k = 0; k < kLanes; ++k) is_idle[k] = true;
  int next = 0, idle = kLanes;
  Pose a_T_b{};
  Float lower{}, upper{}, square{}, limit{};
  Int steps{};
  Point simplex[3] = {}, towards{};
  while (true) {
    if (idle >= kRefill && next < count) {
      for (int k = 0; k < kLanes; ++k) {
        is_fresh[k] = 0;
        if (!is_idle[k] || next == count) continue;
        item[k] = next++;
        for (int row = 0; row < kPoseRows; ++row) taken[row][k] = items.pose[row][columns[item[k]]];
        for (int row = 0; row < 3; ++row) taken[kPoseRows + row][k] = items.cso_point[row][columns[item[k]]];
        taken[kPoseRows + 3][k] = limits[item[k]];
        is_idle[k] = false;
        is_fresh[k] = -1;
        --idle;
      }
      a_T_b = loadPose(taken, 0);
      limit = load(taken[kPoseRows + 3]);
      const Int fresh = *reinterpret_cast<const Int*>(is_fresh);
      towards =
          choose(fresh, Point{load(taken[kPoseRows]), load(taken[kPoseRows + 1]), load(taken[kPoseRows + 2])}, towards);
      lower = fresh ? -infinity : lower;
      upper = fresh ? infinity : upper;
      square = fresh ? infinity : square;
      steps = fresh ? Int{} : steps;
    }
    if (idle == kLanes) return;
    // The bound along the direction, and the vertex of the CSO.
    const Float length2 = dot(towards, towards);
    const Int has_direction = length2 > 1e-36f;
    const Point direction = (-1.0f / root(has_direction ? length2 : all(1.0f))) * towards;  // from a to b
    const Point in_b = turnedBack(a_T_b.rotation, direction);
    const Support a = vertex(cores.a, direction), b = vertex(cores.b, Point{-in_b.x, -in_b.y, -in_b.z});
    const Float gap = ((dot(direction, a_T_b.origin) - b.height) - a.height) - cores.error;
    lower = (has_direction & (gap > lower)) ? gap : lower;
    const Point newest = a.point - (a_T_b.origin + turned(a_T_b.rotation, b.point));
    for (Point& p : simplex) p = choose(steps == 0, newest, p);
    steps = steps + 1;
    const Nearest found = nearest(simplex, newest);
    const Int is_nearer = found.square < square;
    Int ends = found.is_inside & ~(lower > 0.0f);
    if (any(ends)) {
      const Point corners[4] = {newest, simplex[0], simplex[1], simplex[2]};
      upper = ends & isDeepInside(corners, cores.error) ? all(0.0f) : upper;
    }
    const Float nearer = root(found.square) + cores.error;
    upper = (is_nearer & (nearer < upper)) ? nearer : upper;
    square = is_nearer ? found.square : square;
    ends = ends | ~is_nearer | ~has_direction | (lower > limit) | (upper - lower <= accuracy) | (steps >= kSteps);
    const Point first = choose(found.first == 0, simplex[0], choose(found.first == 1, simplex[1], simplex[2]));
    const Point second = choose(found.second == 0, simplex[0], choose(found.second == 1, simplex[1], simplex[2]));
    simplex[0] = newest;
    simplex[1] = first;
    simplex[2] = second;
    towards = found.direction;
    if (!any(ends)) continue;
    alignas(64) float lowers[kLanes], uppers[kLanes];
    store(lower, lowers);
    store(upper, uppers);
    for (int k = 0; k < kLanes; ++k) {
      if (is_idle[k] || !ends[k]) continue;
      lower_bounds[item[k]] = lowers[k];
      upper_bounds[item[k]] = uppers[k];
      is_idle[k] = true;
      ++idle;
    }
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
