#include "peers/point_library.h"

#include "proximity_server/scene/mesh/mesh.h"
#include "proximity_server/scene/model/robot_model.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/distance.h>
#ifdef PROXIMITY_NANOFLANN
#include <nanoflann.hpp>
#endif

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <stdexcept>
#include <utility>

namespace proximity_server::peers {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The order of the meshes for one point.
class NearestFirst {
 public:
  /// Calls measure(mesh, bound), which returns a distance, for the meshes by gapOf(mesh), a lower bound [m], until that is
  /// not below the smallest distance so far. Returns that distance.
  template <typename GapOf, typename Measure>
  double search(std::size_t meshes, double bound, const GapOf& gapOf, const Measure& measure) {
    order_.clear();
    for (std::size_t i = 0; i < meshes; ++i)
      if (const double gap = gapOf(i); gap < bound) order_.emplace_back(gap, i);
    std::sort(order_.begin(), order_.end());
    for (const auto& [gap, mesh] : order_) {
      if (gap >= bound) break;
      bound = std::min(bound, measure(mesh, bound));
    }
    return bound;
  }

 private:
  std::vector<std::pair<double, std::size_t>> order_;
};

/// [m] The distance that the peers report for every point that is farther than the threshold.
double beyond(double threshold) { return std::nextafter(threshold, kInfinity); }

class FclPoints : public PointLibrary {
 public:
  explicit FclPoints(const std::vector<LinkMesh>& meshes) : point_(std::make_shared<fcl::Sphered>(0.0)) {
    for (const LinkMesh& link : meshes) {
      const auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
      std::vector<fcl::Triangle> triangles;
      for (const std::array<int, 3>& t : link.mesh.triangles)
        triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                               static_cast<std::size_t>(t[2]));
      model->beginModel();
      model->addSubModel(link.mesh.vertices, triangles);
      model->endModel();
      parts_.push_back({link.body, link.body_T_mesh, fcl::CollisionObjectd(model)});
    }
  }

  void ask(const BodyPoses& poses, const std::vector<Vector3d>& points, double threshold,
           std::vector<double>& distances) override {
    for (Part& part : parts_) {
      part.object.setTransform(*poses[part.body] * part.body_T_mesh);
      part.object.computeAABB();
    }
    distances.clear();
    for (const Vector3d& point : points) {
      point_.setTranslation(point);
      const fcl::AABBd box(point);
      const auto gapOf = [&](std::size_t i) { return parts_[i].object.getAABB().distance(box); };
      const auto measure = [&](std::size_t i, double bound) {
        fcl::DistanceResultd result;
        result.min_distance = bound;
        fcl::distance(&parts_[i].object, &point_, fcl::DistanceRequestd(), result);
        return result.min_distance;
      };
      distances.push_back(nearest_.search(parts_.size(), beyond(threshold), gapOf, measure));
    }
  }

 private:
  struct Part {
    int body;
    Isometry3d body_T_mesh;
    fcl::CollisionObjectd object;
  };
  std::vector<Part> parts_;
  fcl::CollisionObjectd point_;
  NearestFirst nearest_;
};

#ifdef PROXIMITY_NANOFLANN
struct Vertices {
  std::vector<Vector3d> points;

  // The names are nanoflann's.
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t point, std::size_t axis) const { return points[point][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

class VertexTrees : public PointLibrary {
 public:
  explicit VertexTrees(const std::vector<LinkMesh>& meshes) {
    for (const LinkMesh& link : meshes) trees_.emplace_back(link);
  }

  void ask(const BodyPoses& poses, const std::vector<Vector3d>& points, double threshold,
           std::vector<double>& distances) override {
    for (LinkTree& tree : trees_) tree.mesh_T_world = (*poses[tree.body] * tree.body_T_mesh).inverse();
    distances.clear();
    for (const Vector3d& point : points) {
      const auto gapOf = [&](std::size_t i) { return trees_[i].box.exteriorDistance(trees_[i].mesh_T_world * point); };
      const auto measure = [&](std::size_t i, double /*bound*/) {
        const Vector3d in_mesh = trees_[i].mesh_T_world * point;
        std::size_t vertex = 0;
        double squared = 0.0;
        trees_[i].tree.knnSearch(in_mesh.data(), 1, &vertex, &squared);
        return std::sqrt(squared);
      };
      distances.push_back(nearest_.search(trees_.size(), beyond(threshold), gapOf, measure));
    }
  }

 private:
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Vertices>, Vertices, 3, std::size_t>;
  struct LinkTree {
    explicit LinkTree(const LinkMesh& link)
        : body(link.body), body_T_mesh(link.body_T_mesh), vertices{link.mesh.vertices}, tree(3, vertices) {
      for (const Vector3d& vertex : vertices.points) box.extend(vertex);
      tree.buildIndex();
    }

    int body;
    Isometry3d body_T_mesh, mesh_T_world;
    Vertices vertices;
    Eigen::AlignedBox3d box;
    Tree tree;
  };
  std::deque<LinkTree> trees_;  // their trees refer to their vertices
  NearestFirst nearest_;
};
#endif

TriangleMesh meshOfBox(const Vector3d& half) {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(half.cwiseProduct(Vector3d(i % 2 * 2 - 1, i / 2 % 2 * 2 - 1, i / 4 * 2 - 1)));
  const narrowphase::ConvexHull hull(corners);
  return {hull.vertices(), hull.triangles()};
}

}  // namespace

std::vector<LinkMesh> linkMeshes(const RobotModel& robot, const MeshResolver& resolve) {
  const std::string begin = "mesh ";
  std::vector<LinkMesh> meshes;
  for (const Collision& collision : robot.collisions) {
    const Piece& piece = robot.pieces[collision.pieces.front()];
    const bool is_mesh = collision.description.rfind(begin, 0) == 0;
    if (!is_mesh && piece.shape.kind() != narrowphase::Shape::Kind::Box)
      throw std::invalid_argument(collision.description + " is no mesh of a file, and no box");
    meshes.push_back({robot.links[collision.link].body, piece.body_T_piece,
                      is_mesh ? loadMesh(resolve(collision.description.substr(begin.size())), Vector3d::Ones())
                              : meshOfBox(piece.shape.halfExtents())});
  }
  return meshes;
}

std::unique_ptr<PointLibrary> fclPoints(const std::vector<LinkMesh>& meshes) {
  return std::make_unique<FclPoints>(meshes);
}

std::unique_ptr<PointLibrary> vertexTrees([[maybe_unused]] const std::vector<LinkMesh>& meshes) {
#ifdef PROXIMITY_NANOFLANN
  return std::make_unique<VertexTrees>(meshes);
#else
  return nullptr;
#endif
}

}  // namespace proximity_server::peers
