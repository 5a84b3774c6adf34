#include "tools/second_opinion/placed_pieces.h"

#include "proximity_server/scene/motion/frames_on_links.h"

#include <variant>

namespace proximity_server::tools {
namespace {

using Eigen::Isometry3d;
using scene::BodyPoses;
using scene::RobotModel;

/// Moving objects stand in frames that are links, as a tool has no tf.
Isometry3d poseOf(const scene::Object& object, const RobotModel& robot, const BodyPoses& poses) {
  if (const auto* fixed = std::get_if<scene::Fixed>(&object.placement)) return fixed->world_T_object;
  const Isometry3d pose = scene::poseOfLink(robot, scene::carryingLink(robot, object), poses);
  if (const auto* moving = std::get_if<scene::Moving>(&object.placement)) return pose * moving->frame_T_object;
  return pose * std::get<scene::Attached>(object.placement).link_T_object;
}

void add(const scene::Piece& piece, const Isometry3d& pose, PlacedPieces& placed) {
  placed.pieces.push_back({&piece, pose * piece.body_T_piece});
  if (piece.interior) placed.has_interior = true;
}

}  // namespace

PlacedPieces placedPieces(const scene::ShapeRef& ref, const RobotModel& robot, const scene::Objects* objects,
                          const BodyPoses& poses) {
  PlacedPieces placed;
  if (ref.isObject()) {
    const scene::Object& object = *objects->object(ref.object());
    const Isometry3d pose = poseOf(object, robot, poses);
    for (const scene::Piece& piece : scene::piecesOf(object)) add(piece, pose, placed);
    placed.has_half_space = scene::hasHalfSpace(object);
    return placed;
  }
  const Isometry3d& pose = *poses[robot.links[ref.link()].body];
  for (const int piece : robot.piecesOf(ref.link())) add(robot.pieces[piece], pose, placed);
  return placed;
}

}  // namespace proximity_server::tools
