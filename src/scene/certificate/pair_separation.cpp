#include "scene/certificate/pair_separation.h"

#include "proximity_server/scene/model/names.h"
#include "scene/objects/placed_object.h"
#include "scene/pieces/interior.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

using Side = CarriedShape;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

void addPiece(const Piece& piece, const Isometry3d& body_T_frame, double chain, Side& side) {
  side.pieces.push_back({&piece, body_T_frame * piece.body_T_piece,
                         chain + piece.body_T_piece.translation().norm() + piece.shape.coreReach()});
}

Side sideOfLink(const RobotModel& robot, int link) {
  Side side{robot.links[link].body, {}, {}};
  for (const int piece : robot.piecesOf(link)) addPiece(robot.pieces[piece], Isometry3d::Identity(), 0.0, side);
  return side;
}

/// The body that carries an object, and the frame on it in which the object has its geometry.
std::pair<int, Isometry3d> carrierOf(const PlacedObject& object, const RobotModel& robot) {
  switch (object.kind) {
    case PlacedObject::Kind::Attached:
      return {object.body, Isometry3d::Identity()};
    case PlacedObject::Kind::Fixed:
      return {robot.links[robot.rootLink()].body, object.world_T_object};
    case PlacedObject::Kind::Moving:
      break;
  }
  const int link = robot.findLink(object.frame);
  if (link < 0) throw std::invalid_argument("the frame of object " + quoted(object.object.id) + " is no link");
  return {robot.links[link].body, robot.links[link].body_T_link};
}

Side sideOfObject(const PlacedObject& object, const RobotModel& robot) {
  const auto [body, body_T_frame] = carrierOf(object, robot);
  Side side{body, {}, {}};
  // excessRounding() is the rounding by the lengths of transforms that have cancelled each other.
  const double excess = object.geometry->excessRounding() / kChainRounding;
  const double chain = body_T_frame.translation().norm() + excess;
  for (const Piece& piece : object.geometry->pieces()) addPiece(piece, body_T_frame, chain, side);
  for (const PlacedHalfSpace& half_space : object.geometry->halfSpaces()) {
    const Vector3d normal = body_T_frame.linear() * half_space.normal;
    side.half_spaces.push_back(
        {normal, half_space.offset + normal.dot(body_T_frame.translation()), chain + std::abs(half_space.offset)});
  }
  return side;
}

Side sideOf(const ShapeRef& ref, const RobotModel& robot, const Objects* objects) {
  const int links = static_cast<int>(robot.links.size());
  if (ref.isLink() && ref.link() < links && ref.collision() == 0) return sideOfLink(robot, ref.link());
  const bool is_object = ref.isObject() && ref.collision() == 0 && objects && ref.object() < objects->numberLimit();
  const PlacedObject* object = is_object ? objects->placed(ref.object()) : nullptr;
  if (!object) throw std::invalid_argument("a certificate is about whole links and objects, and one does not exist");
  return sideOfObject(*object, robot);
}

bool hasInteriorPiece(const Side& side) {
  return std::any_of(side.pieces.begin(), side.pieces.end(),
                     [](const Side::CarriedPiece& piece) { return piece.piece->interior != nullptr; });
}

}  // namespace

PairSeparation::PairSeparation(const SceneModel& model, const Objects* objects, const ShapeRefPair& pair)
    : robot_(model.robot), a_(sideOf(pair.a, robot_, objects)), b_(sideOf(pair.b, robot_, objects)) {
  if (!a_.half_spaces.empty() && !b_.half_spaces.empty())
    throw std::invalid_argument("the distance of two half-spaces is not known");
  if (robot_.bodies[a_.body].robot != robot_.bodies[b_.body].robot)
    throw std::invalid_argument("the places of several robots are not known");
  std::set<int> leaders;
  bodies_.push_back(a_.body);
  for (const int number : jointsBetween(robot_, a_.body, b_.body)) {
    const Joint& joint = robot_.joints[number];
    const int leader = robot_.leaderOf(number).joint;
    if (!hasOnePosition(joint) || !hasOnePosition(robot_.joints[leader]))
      throw std::invalid_argument("joint " + quoted(joint.name) + " has more than one position");
    leaders.insert(leader);
    const int below = robot_.links[joint.child_link].body;
    bodies_.push_back(bodies_.back() == below ? robot_.links[joint.parent_link].body : below);
  }
  leaders_.assign(leaders.begin(), leaders.end());
  if (!pair.areLinks()) return;
  const int index = model.pairs.find(pair.a.link(), pair.b.link());
  if (index >= 0) padding_ = model.pairs.pairs[index].padding;
}

/// [m] How high the pieces of a side reach along a unit direction that is fixed to a body; of one piece, or of all for -1.
VectorXd PairSeparation::highest(const Side& side, int body, const Vector3d& direction,
                                 const std::vector<JointRange>& box, int only) const {
  const AxisHeights heights(robot_, box, body, side.body, direction);
  const Eigen::Index begin = std::max(only, 0),
                     end = only < 0 ? static_cast<Eigen::Index>(side.pieces.size()) : only + 1;
  VectorXd highest(end - begin);
  for (Eigen::Index i = begin; i < end; ++i) {
    const Side::CarriedPiece& piece = side.pieces[static_cast<std::size_t>(i)];
    highest[i - begin] = heights.highest(piece.piece->shape, piece.body_T_piece, piece.reach);
  }
  return highest;
}

MatrixXd PairSeparation::along(const std::vector<SeparatingAxis>& axes, const std::vector<JointRange>& box) const {
  const auto rows = static_cast<Eigen::Index>(a_.pieces.size()), columns = static_cast<Eigen::Index>(b_.pieces.size());
  MatrixXd best = MatrixXd::Constant(rows, columns, -kInfinite);
  for (const SeparatingAxis& axis : axes) {
    const int body = robot_.links[axis.link].body;
    const Vector3d direction = axis.direction.normalized();
    const VectorXd of_a = highest(a_, body, direction, box), of_b = highest(b_, body, -direction, box);
    best = best.cwiseMax(-(of_a.replicate(1, columns) + of_b.transpose().replicate(rows, 1)));
  }
  return best;
}

double PairSeparation::along(const SeparatingAxis& axis, const std::vector<JointRange>& box, int piece_a,
                             int piece_b) const {
  const int body = robot_.links[axis.link].body;
  const Vector3d direction = axis.direction.normalized();
  return -(highest(a_, body, direction, box, piece_a)[0] + highest(b_, body, -direction, box, piece_b)[0]);
}

double PairSeparation::fromHalfSpaces(const std::vector<JointRange>& box) const {
  const Side &solid = a_.half_spaces.empty() ? b_ : a_, &other = a_.half_spaces.empty() ? a_ : b_;
  double least = kInfinite;
  for (const Side::CarriedHalfSpace& half_space : solid.half_spaces) {
    const VectorXd backwards = highest(other, solid.body, -half_space.normal, box);
    least = std::min(least, -backwards.maxCoeff() - half_space.offset - kChainRounding * half_space.reach);
  }
  return least;
}

double PairSeparation::least(const std::vector<SeparatingAxis>& axes, const std::vector<JointRange>& box) const {
  const MatrixXd separations = along(axes, box);
  return std::min(fromHalfSpaces(box), separations.size() > 0 ? separations.minCoeff() : kInfinite);
}

bool PairSeparation::hasInterior() const { return hasInteriorPiece(a_) || hasInteriorPiece(b_); }

bool PairSeparation::isOutside(std::vector<JointRange> box) const {
  for (JointRange& interval : box) interval.lower = interval.upper = 0.5 * (interval.lower + interval.upper);
  return isOutside(a_, b_, box) && isOutside(b_, a_, box);
}

bool PairSeparation::isOutside(const Side& inner, const Side& outer, const std::vector<JointRange>& state) const {
  constexpr double kNear = 1e-9;  // [m]
  const auto coordinate = [&](int axis, const Vector3d& point) {
    return AxisHeights(robot_, state, outer.body, inner.body, Vector3d::Unit(axis)).of(point);
  };
  for (const Side::CarriedPiece& solid : outer.pieces) {
    if (!solid.piece->interior) continue;
    for (const Side::CarriedPiece& piece : inner.pieces) {
      if (!piece.piece->is_representative) continue;
      const Vector3d centre = piece.body_T_piece * piece.piece->shape.centre();
      const Vector3d in_body(coordinate(0, centre), coordinate(1, centre), coordinate(2, centre));
      const Vector3d in_mesh = solid.body_T_piece.inverse(Eigen::Isometry) * in_body;
      if (!(solid.piece->interior->placeOf(in_mesh).lower_bound > kNear)) return false;
    }
  }
  return true;
}

}  // namespace proximity_server::scene
