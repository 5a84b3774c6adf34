#include "tools/explain/link_pieces.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "tools/states/csv_states.h"

#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

namespace proximity_server::tools {
namespace {

using Eigen::Isometry3d;
using scene::RobotModel;

/// Index of a link with geometry.
int linkOf(const RobotModel& robot, const std::string& urdf, const std::string& name) {
  const int link = robot.findLink(name);
  if (link < 0)
    throw std::invalid_argument(urdf + ": no link " + scene::unknownName(name, scene::namesOf(robot.links)));
  if (!robot.hasGeometry(link)) throw std::invalid_argument(urdf + ": link \"" + name + "\" has no collision geometry");
  return link;
}

struct NamedPiece {
  const scene::Piece* piece;
  Isometry3d pose;
  std::string name;
};

std::vector<NamedPiece> piecesOf(const RobotModel& robot, int link, const scene::BodyPoses& poses) {
  const std::optional<Isometry3d>& body_pose = poses[robot.links[link].body];
  if (!body_pose)
    throw std::invalid_argument("--state: does not tell where link \"" + robot.links[link].name + "\" is");
  std::vector<NamedPiece> pieces;
  for (const int number : robot.links[link].collisions) {
    const scene::Collision& collision = robot.collisions[number];
    for (std::size_t i = 0; i < collision.pieces.size(); ++i) {
      const scene::Piece& piece = robot.pieces[collision.pieces[i]];
      std::string name = robot.links[link].name + ", " + collision.description;
      if (collision.pieces.size() > 1) {
        name += ", piece " + std::to_string(i + 1) + " of " + std::to_string(collision.pieces.size());
      }
      pieces.push_back({&piece, *body_pose * piece.body_T_piece, name});
    }
  }
  return pieces;
}

ExplainedShape explained(const NamedPiece& placed) {
  ExplainedShape shape{placed.piece->shape, placed.name, {}};
  if (shape.shape.kind() == narrowphase::Shape::Kind::Hull) shape.points = shape.shape.hull().vertices();
  return shape;
}

}  // namespace

ExplainedPair closestPieces(const RobotFiles& files, const std::string& link_a, const std::string& link_b,
                            const std::optional<std::string>& state) {
  const std::shared_ptr<const scene::SceneModel> model = loadSceneModel(files);
  const RobotModel& robot = model->robot;
  printWarnings(robot.warnings, files.warnings);  // not those about pairs, as this is about one
  const int a = linkOf(robot, files.urdf, link_a), b = linkOf(robot, files.urdf, link_b);
  if (a == b) throw std::invalid_argument(files.urdf + ": the two links are the same, \"" + link_a + '"');
  const std::vector<double> positions =
      state ? readState("--state", *state, robot, files.warnings) : std::vector<double>(robot.joints.size(), 0.0);
  const scene::BodyPoses poses = scene::forwardKinematics(robot, positions);
  const std::vector<NamedPiece> of_a = piecesOf(robot, a, poses), of_b = piecesOf(robot, b, poses);
  const NamedPiece *closest_a = nullptr, *closest_b = nullptr;
  double smallest = std::numeric_limits<double>::infinity();
  for (const NamedPiece& piece_a : of_a) {
    for (const NamedPiece& piece_b : of_b) {
      const Isometry3d a_T_b = piece_a.pose.inverse() * piece_b.pose;
      const double lower = signedDistance(piece_a.piece->shape, piece_b.piece->shape, a_T_b).lower_bound;
      if (closest_a != nullptr && !(lower < smallest)) continue;
      smallest = lower;
      closest_a = &piece_a;
      closest_b = &piece_b;
    }
  }
  return {explained(*closest_a), explained(*closest_b), closest_a->pose.inverse() * closest_b->pose};
}

}  // namespace proximity_server::tools
