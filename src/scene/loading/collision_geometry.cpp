#include "scene/loading/collision_geometry.h"

#include "scene/mesh/mesh_file.h"
#include "scene/mesh/stop_flag.h"
#include "system/child_process.h"
#include "system/pipeline.h"
#include "system/relay.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <type_traits>

namespace urdf {
class Capsule;  // not every version of urdfdom has it
}

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

Vector3d vectorOf(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

template <typename... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

/// Reads a <capsule> if this version of urdfdom has a class for it.
template <typename UrdfCapsule, typename = void>
struct CapsuleReader {
  static std::optional<CollisionGeometry> read(const urdf::Geometry& /*geometry*/) { return std::nullopt; }
};
template <typename UrdfCapsule>
struct CapsuleReader<UrdfCapsule, std::void_t<decltype(sizeof(UrdfCapsule))>> {
  static std::optional<CollisionGeometry> read(const urdf::Geometry& geometry) {
    const auto* capsule = dynamic_cast<const UrdfCapsule*>(&geometry);
    if (!capsule) return std::nullopt;
    return CollisionGeometry{text("capsule, radius ", capsule->radius, ", length ", capsule->length),
                             {narrowphase::Capsule{capsule->radius, capsule->length}}};
  }
};

/// Returns the index of the collision that is a sphere of this radius with this centre, or -1.
int findSphere(const std::vector<urdf::CollisionSharedPtr>& collisions, double radius, const Vector3d& centre,
               double rounding) {
  for (std::size_t i = 0; i < collisions.size(); ++i) {
    const auto* sphere = dynamic_cast<const urdf::Sphere*>(collisions[i]->geometry.get());
    if (!sphere || sphere->radius != radius) continue;
    if ((vectorOf(collisions[i]->origin.position) - centre).norm() <= rounding) return static_cast<int>(i);
  }
  return -1;
}

/// The number of threads that read so many meshes. Each thread uses child processes.
int usefulThreads(std::size_t meshes, int threads) {
  if (!system::kMayForkBesideThreads) return 1;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return std::min(static_cast<int>(meshes), threads > 0 ? threads : cores);
}

}  // namespace

Eigen::Isometry3d toEigen(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  return Eigen::Translation3d(vectorOf(pose.position)) * Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

CollisionGeometry GeometryReader::read(const urdf::Geometry& geometry, const MeshOptions& options) {
  if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) {
    requireNoStop(options.stop);
    const MeshKey key = keyOf(*mesh, options);
    auto known = meshes_.find(key);
    if (known == meshes_.end()) known = meshes_.emplace(key, outcomeOf(key, mesh->filename, options)).first;
    if (known->second.error) std::rethrow_exception(known->second.error);
    return known->second.geometry;
  }
  if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
    return {text("sphere, radius ", sphere->radius), {narrowphase::Sphere{sphere->radius}}};
  }
  if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
    return {text("box ", box->dim.x, " x ", box->dim.y, " x ", box->dim.z), {narrowphase::Box{vectorOf(box->dim)}}};
  }
  if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
    return {text("cylinder, radius ", cylinder->radius, ", length ", cylinder->length),
            {narrowphase::Cylinder{cylinder->radius, cylinder->length}}};
  }
  if (auto capsule = CapsuleReader<urdf::Capsule>::read(geometry)) return *capsule;
  throw std::invalid_argument("a shape that is no sphere, box, cylinder, capsule or mesh");
}

GeometryReader::MeshKey GeometryReader::keyOf(const urdf::Mesh& mesh, const MeshOptions& options) const {
  return {resolve_(mesh.filename), {mesh.scale.x, mesh.scale.y, mesh.scale.z}, options.tolerance};
}

GeometryReader::Outcome GeometryReader::outcomeOf(const MeshKey& key, const std::string& uri,
                                                  const MeshOptions& options) try {
  MeshOptions telling = options;
  if (options.progress)
    telling.progress = [&](const std::string& what) { options.progress("mesh " + uri + ": " + what); };
  CollisionGeometry geometry{"mesh " + uri, {}};
  const MeshWithUnit file = readMesh(key.file, {key.scale[0], key.scale[1], key.scale[2]}, options.stop);
  geometry.mesh = convexPieces(file.mesh, telling);
  geometry.unit_remark = unitRemark(file.unit);
  for (std::string* sentence : {&geometry.mesh.shortfall, &geometry.mesh.openness})
    if (!sentence->empty()) sentence->insert(0, geometry.description + ": ");
  for (narrowphase::ConvexHull& hull : geometry.mesh.hulls) geometry.shapes.emplace_back(std::move(hull));
  geometry.mesh.hulls.clear();
  return {std::move(geometry), nullptr};
} catch (const std::exception&) {
  return {{}, std::current_exception()};
}

void GeometryReader::readAhead(const std::vector<MeshRequest>& requests, int threads, Failure failure) {
  std::vector<MeshAhead> entries;
  std::set<MeshKey> seen;
  for (const MeshRequest& request : requests) {
    try {
      const MeshKey key = keyOf(*request.mesh, request.options);
      if (meshes_.count(key) == 0 && seen.insert(key).second) entries.push_back({key, &request});
    } catch (const std::invalid_argument&) {
      if (failure == Failure::EndsIt) return;
    }
  }
  if (!entries.empty()) readAll(entries, usefulThreads(entries.size(), threads), failure);
  for (MeshAhead& entry : entries) {
    if (entry.is_done) meshes_.emplace(std::move(entry.key), std::move(entry.outcome));
  }
}

void GeometryReader::readAll(std::vector<MeshAhead>& meshes, int threads, Failure failure) {
  std::atomic<bool> ended{false};
  const auto tell = [&](const MeshAhead& mesh, const std::string& text) {
    try {
      mesh.request->options.progress(text);
    } catch (...) {
      ended = true;
      throw;
    }
  };
  auto begin = meshes.begin();
  const auto next = [&](MeshAhead*& mesh) {
    if (ended || begin == meshes.end()) return false;
    mesh = &*begin++;
    return true;
  };
  system::runRelayed([&](const system::CallHere& callHere) {
    const auto read = [&](MeshAhead* mesh, int) {
      MeshOptions options = mesh->request->options;
      if (options.progress)
        options.progress = [&, mesh](const std::string& text) { callHere([&tell, mesh, text] { tell(*mesh, text); }); };
      mesh->outcome = outcomeOf(mesh->key, mesh->request->mesh->filename, options);
      mesh->is_done = true;
      if (mesh->outcome.error && failure == Failure::EndsIt) ended = true;
    };
    system::runPipeline<MeshAhead*>({next, read}, {threads, system::PipelineThreads::TooFew::Enough});
  });
}

std::vector<CapsuleParts> findCapsules(const std::vector<urdf::CollisionSharedPtr>& collisions) {
  std::vector<CapsuleParts> capsules;
  for (std::size_t i = 0; i < collisions.size(); ++i) {
    const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(collisions[i]->geometry.get());
    if (!cylinder) continue;
    const Eigen::Isometry3d pose = toEigen(collisions[i]->origin);
    // The sines of rpy, the products of the quaternion and the sums of a rotated end each add one or two eps of the
    // lengths.
    const double rounding =
        16.0 * std::numeric_limits<double>::epsilon() * (pose.translation().norm() + cylinder->length);
    const auto sphereAt = [&](double z) {
      return findSphere(collisions, cylinder->radius, pose * Vector3d(0, 0, z), rounding);
    };
    const std::array<int, 2> spheres{sphereAt(-0.5 * cylinder->length), sphereAt(0.5 * cylinder->length)};
    if (spheres[0] < 0 || spheres[1] < 0) continue;
    capsules.push_back({static_cast<int>(i), spheres, {cylinder->radius, cylinder->length}});
  }
  return capsules;
}

}  // namespace proximity_server::scene
