#include "tools/second_opinion/fcl_shape.h"
#include "tools/second_opinion/other_library.h"

#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

using Eigen::Vector3d;
using narrowphase::Shape;
using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

bool isFlat(const Shape& shape) {
  return shape.kind() == Shape::Kind::Hull && shape.margin() == 0.0 && shape.hull().dimension() < 3;
}

Geometry geometryOf(const Shape& shape) {
  if (!isFlat(shape)) return fclShape(shape);
  const auto mesh = std::make_shared<FclMesh>();
  mesh->beginModel();
  addTriangles(*mesh, shape, Eigen::Isometry3d::Identity());
  mesh->endModel();
  return mesh;
}

class Fcl {
 public:
  OtherAnswer operator()(const PlacedPieces& a, const PlacedPieces& b) {
    if (a.has_half_space || b.has_half_space) return {};
    std::vector<fcl::CollisionObjectd> of_a, of_b;
    try {
      of_a = placed(a);
      of_b = placed(b);
    } catch (const std::invalid_argument&) {
      return {};
    }
    OtherAnswer nearest;
    nearest.distance = std::numeric_limits<double>::infinity();
    for (const fcl::CollisionObjectd& piece_a : of_a)
      for (const fcl::CollisionObjectd& piece_b : of_b) offer(piece_a, piece_b, nearest);
    return nearest;
  }

 private:
  std::vector<fcl::CollisionObjectd> placed(const PlacedPieces& body) {
    std::vector<fcl::CollisionObjectd> objects;
    for (const PlacedPiece& piece : body.pieces) {
      Geometry& geometry = geometries_[piece.piece];
      if (!geometry) geometry = geometryOf(piece.piece->shape);
      objects.emplace_back(geometry, piece.world_T_piece);
      objects.back().computeAABB();
    }
    return objects;
  }

  /// Takes the answer about two pieces if they are nearer.
  static void offer(const fcl::CollisionObjectd& a, const fcl::CollisionObjectd& b, OtherAnswer& nearest) {
    if (a.getAABB().distance(b.getAABB()) > std::max(nearest.distance, 0.0)) return;
    const OtherAnswer answer = ofPieces(a, b);
    if (nearest.kind == OtherAnswer::Kind::Overlap) return;  // the depth of all is not known
    if (answer.kind == OtherAnswer::Kind::Overlap || answer.distance < nearest.distance) nearest = answer;
  }

  static OtherAnswer ofPieces(const fcl::CollisionObjectd& a, const fcl::CollisionObjectd& b) {
    fcl::DistanceRequestd request(true);
    const OtherAnswer answer = ofRequest(a, b, request);
    if (answer.distance > 0.0) return answer;
    const bool have_depth = a.getObjectType() == fcl::OT_GEOM && b.getObjectType() == fcl::OT_GEOM;
    if (!have_depth) return {OtherAnswer::Kind::Overlap, 0.0, answer.point_a, answer.point_b};
    request.enable_signed_distance = true;
    return ofRequest(a, b, request);
  }

  static OtherAnswer ofRequest(const fcl::CollisionObjectd& a, const fcl::CollisionObjectd& b,
                               const fcl::DistanceRequestd& request) {
    fcl::DistanceResultd result;
    fcl::distance(&a, &b, request, result);
    const Vector3d &p = result.nearest_points[0], &q = result.nearest_points[1];
    return {OtherAnswer::Kind::Distance, result.min_distance, {p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z()}};
  }

  std::map<const scene::Piece*, Geometry> geometries_;
};

}  // namespace

AskOther makeFcl() { return Fcl(); }

}  // namespace proximity_server::tools
