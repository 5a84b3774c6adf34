#include "scene/lanes/lane_model.h"

#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/pairs.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kUnit = 0x1p-24;      // the relative rounding error of float
constexpr double kWideUnit = 0x1p-53;  // and of double
constexpr double kSecondOrder = 1.01;  // for products of errors, and the rounding in double of these bounds
const double kNormOfRotation = std::sqrt(3.0);

// [m] For a sliding joint without limits. A state may have a larger position; the lanes then leave it to other steps.
constexpr double kMostSlide = 10.0;

template <typename Number>
void assign(const Matrix3d& matrix, Number (&rows)[9]) {
  for (int i = 0; i < 9; ++i) rows[i] = static_cast<Number>(matrix(i / 3, i % 3));
}
template <typename Number>
void assign(const Vector3d& vector, Number (&values)[3]) {
  for (int i = 0; i < 3; ++i) values[i] = static_cast<Number>(vector[i]);
}

/// How something stands on a parent: see LaneError.
struct Stand {
  double rotation_error;
  double origin_error;  ///< [m]
  double length;        ///< [m] upper bound of the distance of the origins
};

LaneError errorOn(const LaneError& parent, const Stand& stand) {
  LaneError error;
  const double norm = kNormOfRotation + parent.rotation;
  error.rotation = kSecondOrder * (parent.rotation * (1.0 + stand.rotation_error) + stand.rotation_error +
                                   3.0 * kWideUnit * norm * (kNormOfRotation + stand.rotation_error));
  error.reach = parent.reach + stand.length;
  error.origin = kSecondOrder * (parent.origin + parent.rotation * stand.length + stand.origin_error * norm +
                                 3.0 * kWideUnit * norm * stand.length + kWideUnit * error.reach);
  return error;
}

LaneError roundedToFloat(LaneError error) {
  error.rotation += kSecondOrder * kUnit * kNormOfRotation;
  error.origin += kSecondOrder * kUnit * error.reach;
  return error;
}

Matrix3d crossMatrix(const Vector3d& axis) {
  Matrix3d matrix;
  matrix << 0.0, -axis.z(), axis.y(), axis.z(), 0.0, -axis.x(), -axis.y(), axis.x(), 0.0;
  return matrix;
}

/// How a joint moves what it carries: see lanes::BodyPlan.
struct JointMatrices {
  Matrix3d fixed, by_sine = Matrix3d::Zero(), by_cosine = Matrix3d::Zero();
  Vector3d direction = Vector3d::Zero();
};

/// `turned` is the rotation of the joint on the body that carries it.
JointMatrices matricesOf(const Joint& joint, const Matrix3d& turned) {
  JointMatrices matrices;
  matrices.fixed = turned;
  switch (joint.type) {
    case Joint::Type::Revolute:
    case Joint::Type::Continuous:
      matrices.fixed = turned * joint.axis * joint.axis.transpose();
      matrices.by_sine = turned * crossMatrix(joint.axis);
      matrices.by_cosine = turned - matrices.fixed;
      break;
    case Joint::Type::Prismatic:
      matrices.direction = turned * joint.axis;
      break;
    case Joint::Type::Floating:
    case Joint::Type::Planar:
      break;
  }
  return matrices;
}

bool isTurning(const Joint& joint) {
  return joint.type == Joint::Type::Revolute || joint.type == Joint::Type::Continuous;
}

/// The largest position that a joint reaches while its leader is within its limits.
double mostOf(const Joint& leader, const Joint::Mimic& mimic) {
  const double most = std::max(std::abs(leader.lower), std::abs(leader.upper));
  const double position = std::abs(mimic.offset) + std::abs(mimic.multiplier) * most;
  return std::isfinite(position) ? std::clamp(position, 1e-3, kMostSlide) : kMostSlide;
}

lanes::Balls ballsOf(const LaneModel::BallRows& rows) {
  return {static_cast<int>(rows[0].size()), rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data()};
}

/// A point of the body in the frame of the box of its link.
Vector3d inFrameOf(const Bounds& bounds, const Vector3d& point) {
  return bounds.axes.transpose() * (point - bounds.centre);
}

/// Converts balls to the frame of the box.
LaneModel::BallRows rowsOf(const std::vector<Ball>& balls, const Bounds& bounds) {
  LaneModel::BallRows rows;
  for (const Ball& ball : balls) {
    const Vector3d centre = inFrameOf(bounds, ball.centre);
    for (int k = 0; k < 3; ++k) rows[k].push_back(static_cast<float>(centre[k]));
    rows[3].push_back(static_cast<float>(ball.radius));
  }
  return rows;
}

/// Adds a box around points of the body, and around the margin [m] of these.
void addBox(const std::vector<Vector3d>& points, double margin, const Bounds& bounds, LaneModel::BoxRows& rows) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& point : points) box.extend(inFrameOf(bounds, point));
  for (int k = 0; k < 3; ++k) {
    rows[k].push_back(static_cast<float>(box.center()[k]));
    rows[3 + k].push_back(roundedUp(0.5 * box.sizes()[k] + margin));
  }
}

LaneModel::Pieces piecesOf(const LinkOutline& outline) {
  LaneModel::Pieces pieces;
  const Bounds& bounds = outline.bounds;
  const double rounding = outline.uncovered;
  for (const PieceOutline& piece : outline.pieces) {
    std::vector<Ball> corners;
    for (const Vector3d& corner : piece.corners) corners.push_back({corner, 0.0});
    pieces.list.push_back({rowsOf(corners, bounds), piece.margin, piece.is_exact});
    addBox(piece.corners, piece.margin + rounding, bounds, pieces.boxes);
  }
  for (const PieceOutline& interior : outline.interiors)
    addBox(interior.corners, interior.margin + rounding, bounds, pieces.interiors);
  for (const Ball& ball : outline.representatives)
    addBox({ball.centre}, ball.radius + rounding, bounds, pieces.representatives);
  return pieces;
}

}  // namespace

LaneModel::LaneModel(const SceneModel& model, const Volumes& volumes) {
  addBodies(model.robot);
  findUnread(static_cast<int>(model.robot.joints.size()));
  outlines_.resize(model.robot.links.size());
  const Candidates candidates(model.pairs);
  const PairDistances paddings = paddingsOf(model.pairs);
  for (const ShapeRefPair& candidate : candidates) {
    const int link_a = candidate.a.link(), link_b = candidate.b.link();
    for (const int link : {link_a, link_b}) addLink(model.robot, link, volumes[link].bounds);
    const Link *a = outlines_[link_a].get(), *b = outlines_[link_b].get();
    pairs.push_back(a && b ? pairOf(*a, *b, paddings.of(candidate)) : Pair{});
  }
}

/// Adds a column for the position of a joint and returns its row.
int LaneModel::rowOf(const RobotModel& robot, int joint, std::vector<Column>& columns) {
  const Joint::Mimic leader = robot.leaderOf(joint);
  const double limit = &columns == &turns ? lanes::kMostAngle : mostOf(robot.joints[leader.joint], leader);
  columns.push_back({leader.joint, leader.multiplier, leader.offset, limit});
  return static_cast<int>(columns.size()) - 1;
}

void LaneModel::findUnread(int joints) {
  std::vector<bool> is_read(static_cast<std::size_t>(joints), false);
  for (const Column& column : turns) is_read[column.joint] = true;
  for (const Column& column : slides) is_read[column.joint] = true;
  for (int joint = 0; joint < joints; ++joint)
    if (!is_read[joint]) unread.push_back(joint);
}

void LaneModel::addBodies(const RobotModel& robot) {
  for (const Body& body : robot.bodies) {
    if (body.joint >= 0)
      addCarried(robot, body);
    else
      addRoot();
  }
}

void LaneModel::addRoot() {
  lanes::BodyPlan plan{};
  plan.parent = plan.angle_row = plan.position_row = -1;
  assign(Matrix3d::Identity(), plan.fixed);
  bodies.push_back(plan);
  body_errors.emplace_back();
}

/// Adds a body that a joint carries.
void LaneModel::addCarried(const RobotModel& robot, const Body& body) {
  const Joint& joint = robot.joints[body.joint];
  const Eigen::Isometry3d parent_T_joint = robot.links[joint.parent_link].body_T_link * joint.parent_T_joint;
  const JointMatrices matrices = matricesOf(joint, parent_T_joint.linear());
  lanes::BodyPlan plan{};
  plan.parent = body.parent;
  plan.angle_row = isTurning(joint) ? rowOf(robot, body.joint, turns) : -1;
  plan.position_row = joint.type == Joint::Type::Prismatic ? rowOf(robot, body.joint, slides) : -1;
  assign(matrices.fixed, plan.fixed);
  assign(matrices.by_sine, plan.by_sine);
  assign(matrices.by_cosine, plan.by_cosine);
  assign(parent_T_joint.translation(), plan.origin);
  assign(matrices.direction, plan.direction);
  bodies.push_back(plan);
  const double moving = matrices.by_sine.norm() + matrices.by_cosine.norm();
  const double length = parent_T_joint.translation().norm() + (plan.position_row >= 0 ? slides.back().limit : 0.0);
  const Stand stand{4.0 * kWideUnit * (matrices.fixed.norm() + moving) + lanes::kSineError * moving,
                    4.0 * kWideUnit * length, length};
  body_errors.push_back(errorOn(body_errors[body.parent], stand));
}

void LaneModel::addLink(const RobotModel& robot, int link, const Bounds& bounds) {
  std::unique_ptr<Link>& added = outlines_[link];
  if (added || !robot.hasGeometry(link)) return;
  added = std::make_unique<Link>();
  added->outline = outlineOf(robot, link, bounds);
  added->number = static_cast<int>(links.size());
  added->extent = bounds.half.norm();
  for (const Ball& corner : added->outline.corners)
    added->extent = std::max(added->extent, (corner.centre - bounds.centre).norm() + corner.radius);
  added->corners = rowsOf(added->outline.corners, bounds);
  added->inner = rowsOf(added->outline.inner, bounds);
  lanes::LinkPlan plan{};
  plan.body = robot.links[link].body;
  assign(bounds.axes, plan.rotation);
  assign(bounds.centre, plan.origin);
  links.push_back(plan);
  pieces.push_back(piecesOf(added->outline));
  const Stand stand{kWideUnit * kNormOfRotation, kWideUnit * bounds.centre.norm(), bounds.centre.norm()};
  const LaneError error = roundedToFloat(errorOn(body_errors[plan.body], stand));
  link_errors.push_back(error);
  const double radius = added->outline.bounds.radius + added->outline.uncovered;
  link_balls.push_back({roundedUp(radius), roundedUp(2.0 * kSecondOrder * (error.origin + error.rotation * radius))});
}

/// Let C and x be the rotation and origin of b in the frame of a, with errors as in LaneError, and n a direction that
/// is a unit vector within 4 u. A bound adds a few u of the lengths to the errors of C and x:
///
/// * Support heights along n: C n has an error of |C - true C| + 6 u. A height adds 4 u of the extent, its constants u,
///   and the length of n 5 u; the sum of three heights adds 3 u of all lengths. Together at most 20 u of the lengths.
/// * Points of the Minkowski difference: 8 u for a point, and 4 u for each of the at most kMostSteps steps of the
///   search.
/// * Boxes: 6 u for each width, 12 u with the sums. The distance from three gaps has sqrt(3) times their error, and 4
///   u. The centres of the boxes of pieces add less than 16 u of the lengths to each gap: 64 u for all.
/// * GJK: 8 u for a vertex, 2 u for the edges from the newest one, 4 u for their weighted sum, 3 u because the sum of
///   the weights may be above 1 by that, and 3 u for the norm. So its upper bound has the error of a bound along an axis:
///   the weights themselves may be wrong, as any of them give a point of the CSO.
LaneModel::Pair LaneModel::pairOf(const Link& a, const Link& b, double padding) const {
  const LaneError &error_a = link_errors[a.number], &error_b = link_errors[b.number];
  const double apart = error_a.reach + error_b.reach;
  const double of_origins = error_a.origin + error_b.origin;
  const double rotation = kSecondOrder * (error_a.rotation + error_b.rotation + 9.0 * kUnit);
  const double origin = kSecondOrder * (error_a.rotation * apart + of_origins + kUnit * apart + 6.0 * kUnit * apart);
  const double lengths = a.extent + b.extent + apart, moved = origin + rotation * (a.extent + b.extent);

  Pair pair;
  pair.a = a.number;
  pair.b = b.number;
  pair.padding = padding;
  pair.depth =
      (a.outline.bounds.radius + a.outline.uncovered) + (b.outline.bounds.radius + b.outline.uncovered) + padding;
  pair.reach = pair.depth + kSecondOrder * of_origins;
  lanes::PairShapes& shapes = pair.shapes;
  shapes.outline_a = ballsOf(a.corners);
  shapes.outline_b = ballsOf(b.corners);
  shapes.inner_a = ballsOf(a.inner);
  shapes.inner_b = ballsOf(b.inner);
  shapes.uncovered = roundedUp(a.outline.uncovered + b.outline.uncovered);
  assign(inFrameOf(a.outline.bounds, a.outline.inside), shapes.centre_a);
  assign(inFrameOf(b.outline.bounds, b.outline.inside), shapes.centre_b);
  for (int k = 0; k < 3; ++k) {
    shapes.half_a[k] = roundedUp(a.outline.bounds.half[k] + a.outline.uncovered);
    shapes.half_b[k] = roundedUp(b.outline.bounds.half[k] + b.outline.uncovered);
  }
  shapes.is_exact = a.outline.is_exact && b.outline.is_exact;
  shapes.box_error = roundedUp(kSecondOrder * (moved + rotation * apart + 16.0 * kUnit * lengths));
  shapes.lower_error = roundedUp(kSecondOrder * (moved + 20.0 * kUnit * lengths));
  shapes.upper_error = roundedUp(kSecondOrder * (moved + (16.0 + 4.0 * lanes::kMostSteps) * kUnit * lengths));
  pair.coarse_corners_a = static_cast<int>(a.outline.coarse_corners);
  pair.coarse_corners_b = static_cast<int>(b.outline.coarse_corners);
  pair.coarse_uncovered = roundedUp(a.outline.coarse_uncovered + b.outline.coarse_uncovered);
  pair.gap_error = roundedUp(shapes.box_error + 64.0 * kUnit * lengths);
  return pair;
}

bool LaneModel::hasFewPieces(const Pair& pair) const {
  const auto areFew = [](const Pieces& of) { return of.list.size() <= lanes::kMostBoxes; };
  return areFew(pieces[pair.a]) && areFew(pieces[pair.b]);
}

lanes::Cores LaneModel::coresOf(const Pair& pair, std::size_t piece_a, std::size_t piece_b) const {
  const Piece &a = pieces[pair.a].list[piece_a], &b = pieces[pair.b].list[piece_b];
  return {ballsOf(a.corners), ballsOf(b.corners), pair.shapes.lower_error};
}

}  // namespace proximity_server::scene
