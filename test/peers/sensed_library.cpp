#include "peers/sensed_library.h"

#include "peers/aborts.h"
#include "peers/robots.h"
#include "tools/second_opinion/fcl_shape.h"

#include <fcl/geometry/octree/octree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/narrowphase/distance.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace proximity_server::peers {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;

FclSensed::FclSensed(const RobotModel& robot, const std::vector<int>& links, Parts parts) {
  for (const int link : links) {
    const int body = robot.links[link].body;
    const auto add = [&](const Isometry3d& body_T_part, const std::shared_ptr<fcl::CollisionGeometryd>& geometry) {
      parts_.push_back({body, body_T_part, std::make_unique<fcl::CollisionObjectd>(geometry)});
    };
    const auto mesh = std::make_shared<tools::FclMesh>();
    mesh->beginModel();
    bool has_triangles = false;
    for (const Piece* piece : piecesOfLink(robot, link)) {
      const Shape& shape = piece->shape;
      const bool is_flat = shape.kind() == Shape::Kind::Hull && shape.hull().dimension() < 3;
      const bool is_polytope = shape.kind() == Shape::Kind::Hull || shape.kind() == Shape::Kind::Box;
      if (shape.margin() == 0.0 && (is_flat || (is_polytope && parts == Parts::Triangles))) {
        tools::addTriangles(*mesh, shape, piece->body_T_piece);
        has_triangles = true;
      } else {
        add(piece->body_T_piece, tools::fclShape(shape));
      }
    }
    if (!has_triangles) continue;
    mesh->endModel();
    add(Isometry3d::Identity(), mesh);
  }
}

void FclSensed::seeOctree(const std::vector<Vector3d>& points, double resolution) {
  const auto tree = std::make_shared<octomap::OcTree>(resolution);
  constexpr bool kIsOccupied = true, kIsLazy = true;
  for (const Vector3d& point : points) tree->updateNode(point.x(), point.y(), point.z(), kIsOccupied, kIsLazy);
  tree->updateInnerOccupancy();
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> seen;
  seen.push_back(std::make_unique<fcl::CollisionObjectd>(std::make_shared<fcl::OcTreed>(tree)));
  see(std::move(seen));
}

void FclSensed::seeBoxes(const std::vector<Eigen::AlignedBox3d>& boxes) {
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> seen;
  for (const Eigen::AlignedBox3d& box : boxes) {
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = box.center();
    seen.push_back(std::make_unique<fcl::CollisionObjectd>(std::make_shared<fcl::Boxd>(Vector3d(box.sizes())), pose));
  }
  see(std::move(seen));
}

void FclSensed::see(std::vector<std::unique_ptr<fcl::CollisionObjectd>> seen) {
  manager_ = std::make_unique<fcl::DynamicAABBTreeCollisionManagerd>();
  seen_ = std::move(seen);
  std::vector<fcl::CollisionObjectd*> objects;
  for (const auto& object : seen_) objects.push_back(object.get());
  manager_->registerObjects(objects);
  manager_->setup();
}

/// Called for a part and what is seen. Returns whether the search ends: at the first overlap, as MoveIt lets it.
bool FclSensed::visit(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* search, double& reach) {
  auto& found = *static_cast<Search*>(search);
  const std::optional<double> distance = answerOf([&] {
    fcl::DistanceResultd result;
    result.min_distance = found.distance;
    fcl::distance(a, b, fcl::DistanceRequestd(), result);
    return result.min_distance;
  });
  if (!distance) ++found.failures;
  found.distance = std::min(found.distance, distance.value_or(found.distance));
  reach = found.distance;
  return found.distance <= 0.0;
}

double FclSensed::minimum(const BodyPoses& poses) {
  Search search{std::numeric_limits<double>::infinity(), failures_};
  for (const Part& part : parts_) {
    part.object->setTransform(*poses[part.body] * part.body_T_part);
    part.object->computeAABB();
    if (manager_) manager_->distance(part.object.get(), &search, visit);
    if (search.distance <= 0.0) break;
  }
  failures_ = search.failures;
  return search.distance;
}

}  // namespace proximity_server::peers
