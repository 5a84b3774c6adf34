#include "placed_robot.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What a rotation matrix made of single precision numbers may be off: few float eps in each product of columns.
constexpr double kRotationTolerance = 16.0 * std::numeric_limits<float>::epsilon();

bool isPose(const Isometry3d& pose) {
  const double off = (pose.linear().transpose() * pose.linear() - Matrix3d::Identity()).cwiseAbs().maxCoeff();
  // Written so that NaN is refused too.
  return off <= kRotationTolerance && pose.linear().determinant() > 0.0 &&
         std::isfinite(pose.translation().squaredNorm());
}

/// The rotation nearest to a matrix that is one within kRotationTolerance; a rotation stays as it is.
///
/// Source: Higham, Computing the Polar Decomposition, SIAM J. Sci. Stat. Comput. 1986: the Newton-Schulz step squares
/// the error, so that two of them end below eps.
Matrix3d nearestRotation(Matrix3d matrix) {
  for (int step = 0; step < 2; ++step)
    matrix = 0.5 * matrix * (3.0 * Matrix3d::Identity() - matrix.transpose() * matrix);
  return matrix;
}

SignedDistance swapped(SignedDistance result) {
  std::swap(result.point_a, result.point_b);
  result.normal = -result.normal;
  return result;
}

bool hasClosedForm(const Shape& shape) {
  return shape.kind() == Shape::Kind::Point || shape.kind() == Shape::Kind::Segment;
}

}  // namespace

PlacedRobot::PlacedRobot(const RobotModel& model)
    : model_(model), bodies_(model.bodies.size()), pieces_(model.pieces.size()) {
  volumes_.reserve(model.pieces.size() + model.links.size() + model.collisions.size());
  addPieceVolumes();
  for (std::size_t link = 0; link < model.links.size(); ++link)
    addVolume(static_cast<int>(link), piecesOfLink(model.links[link]));
  for (const Collision& collision : model.collisions) addVolume(collision.link, collision.pieces);
}

void PlacedRobot::addPieceVolumes() {
  for (std::size_t i = 0; i < model_.pieces.size(); ++i) {
    const Piece& piece = model_.pieces[i];
    const Collision& collision = model_.collisions[static_cast<std::size_t>(piece.collision)];
    const int body = model_.links[static_cast<std::size_t>(collision.link)].body;
    volumes_.push_back(
        {body, {static_cast<int>(i)}, collision.representation, boundsOf(piece), hasClosedForm(piece.shape)});
  }
}

void PlacedRobot::addVolume(int link, std::vector<int> pieces) {
  Volume volume{model_.links[static_cast<std::size_t>(link)].body, std::move(pieces), Representation::Exact, {}, false};
  std::vector<const Piece*> parts;
  std::vector<const Bounds*> bounds;
  for (const int part : volume.pieces) {
    parts.push_back(&piece(part));
    bounds.push_back(&at(part).bounds);
    volume.representation = std::max(volume.representation, at(part).representation);
  }
  if (!parts.empty()) volume.bounds = boundsOf(parts, bounds);
  volume.closed_form = parts.size() == 1 && hasClosedForm(parts.front()->shape);
  volumes_.push_back(std::move(volume));
}

std::vector<int> PlacedRobot::piecesOfLink(const Link& link) const {
  std::vector<int> pieces;
  for (const int index : model_.bodies[static_cast<std::size_t>(link.body)].pieces) {
    const Collision& collision = model_.collisions[static_cast<std::size_t>(piece(index).collision)];
    if (&model_.links[static_cast<std::size_t>(collision.link)] == &link) pieces.push_back(index);
  }
  return pieces;
}

void PlacedRobot::update(const BodyPoses& poses) {
  if (poses.size() != bodies_.size()) {
    throw std::invalid_argument("the robot has " + std::to_string(bodies_.size()) + " bodies, but there are " +
                                std::to_string(poses.size()) + " poses");
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    bodies_[i].known = poses[i] && isPose(*poses[i]);
    if (!bodies_[i].known) continue;
    bodies_[i].rotation = nearestRotation(poses[i]->linear());
    bodies_[i].origin = poses[i]->translation();
  }
  for (Volume& volume : volumes_) {
    const BodyPlace& body = bodies_[static_cast<std::size_t>(volume.body)];
    if (body.known) volume.offset = body.rotation * volume.bounds.centre;
  }
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const BodyPlace& body = bodyOf(static_cast<int>(i));
    if (!body.known) continue;
    pieces_[i].rotation = body.rotation * model_.pieces[i].body_T_piece.linear();
    pieces_[i].offset = body.rotation * model_.pieces[i].body_T_piece.translation();
  }
}

int PlacedRobot::volumeOf(const Subject& subject) const {
  const int links = static_cast<int>(model_.links.size());
  if (subject.link < 0 || subject.link >= links)
    throw std::invalid_argument("there is no link " + std::to_string(subject.link));
  const int first_link = static_cast<int>(model_.pieces.size());
  if (subject.collision == 0) return first_link + subject.link;

  const Link& link = model_.links[static_cast<std::size_t>(subject.link)];
  if (subject.collision < 0 || subject.collision > static_cast<int>(link.collisions.size()))
    throw std::invalid_argument("link \"" + link.name + "\" has no <collision> " + std::to_string(subject.collision));
  return first_link + links + link.collisions[static_cast<std::size_t>(subject.collision - 1)];
}

bool PlacedRobot::isPlaced(int volume) const { return !at(volume).pieces.empty() && bodyOf(volume).known; }

/// From one centre to the other: the bodies' origins first, as they may be far from that of their frame.
Vector3d PlacedRobot::between(int a, int b) const {
  return (bodyOf(b).origin - bodyOf(a).origin) + (at(b).offset - at(a).offset);
}

double PlacedRobot::sphereGap(int a, int b) const {
  return proximity_server::sphereGap(between(a, b), at(a).bounds, at(b).bounds);
}

double PlacedRobot::boxGap(int a, int b) const {
  const Bounds &bounds_a = at(a).bounds, &bounds_b = at(b).bounds;
  return proximity_server::boxGap(between(a, b), bounds_a, bodyOf(a).rotation * bounds_a.axes, bounds_b,
                                  bodyOf(b).rotation * bounds_b.axes);
}

SignedDistance PlacedRobot::distance(int piece_a, int piece_b, const Options& options, WarmStarts& warm_starts) const {
  if (piece_a > piece_b) return swapped(distance(piece_b, piece_a, options, warm_starts));
  const PiecePlace &a = placeOf(piece_a), &b = placeOf(piece_b);
  const Vector3d offset = (bodyOf(piece_b).origin - bodyOf(piece_a).origin) + (b.offset - a.offset);
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.linear() = a.rotation.transpose() * b.rotation;
  a_T_b.translation() = a.rotation.transpose() * offset;

  const double rounding = kPoseRounding * (offset.norm() + at(piece_a).bounds.reach + at(piece_b).bounds.reach);
  Options inner = options;
  // Twice what the bounds lose, so that the sums below cannot take a decision back.
  inner.distance_tolerance = std::max(0.0, options.distance_tolerance - 4.0 * rounding);
  inner.stop_above += 2.0 * rounding;
  inner.stop_below -= 2.0 * rounding;
  SignedDistance result =
      signedDistance(piece(piece_a).shape, piece(piece_b).shape, a_T_b, inner, warm_starts.of(piece_a, piece_b));
  result.lower_bound -= rounding;
  result.upper_bound += rounding;
  if (result.status == Status::Converged && result.upper_bound - result.lower_bound > options.distance_tolerance)
    result.status = Status::Degenerate;
  result.normal = (a.rotation * result.normal).normalized();
  result.point_a = bodyOf(piece_a).origin + (a.offset + a.rotation * result.point_a);
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

}  // namespace proximity_server
