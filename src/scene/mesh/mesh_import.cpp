#include "scene/mesh/mesh_import.h"

#include "scene/mesh/input_limits.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <Eigen/Geometry>
#include <assimp/Importer.hpp>

#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;

/// A file system that has only one file, with a text in its place if that is not empty.
class OneFile : public Assimp::DefaultIOSystem {
 public:
  OneFile(std::string path, const std::string& text) : path_(std::move(path)), text_(text) {}
  // assimp opens the file to test this.
  bool Exists(const char* path) const override { return path_ == path && DefaultIOSystem::Exists(path); }
  Assimp::IOStream* Open(const char* path, const char* mode) override {
    if (path_ != path) return nullptr;
    if (text_.empty()) return DefaultIOSystem::Open(path, mode);
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(text_.data()), text_.size());
  }

 private:
  std::string path_;
  const std::string& text_;
};

Affine3d toEigen(const aiMatrix4x4& m) {
  Affine3d transform;
  transform.matrix() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, 0, 0, 0, 1;
  return transform;
}

/// Nodes may be instances of other nodes, so that a few lines can stand for any number of triangles.
std::size_t trianglesOf(const aiScene& scene, const aiNode& node) {
  std::size_t triangles = 0;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) triangles += scene.mMeshes[node.mMeshes[i]]->mNumFaces;
  for (unsigned i = 0; i < node.mNumChildren; ++i) triangles += trianglesOf(scene, *node.mChildren[i]);
  return triangles;
}

void appendMesh(const aiMesh& part, const Affine3d& placement, TriangleMesh& mesh) {
  if (mesh.vertices.size() + part.mNumVertices > 3 * kMaxTriangles)
    throw std::runtime_error("it has more than " + std::to_string(3 * kMaxTriangles) + " vertices");
  const int first = static_cast<int>(mesh.vertices.size());
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D& v = part.mVertices[i];
    mesh.vertices.push_back(placement * Vector3d(v.x, v.y, v.z));
  }
  const bool mirrored = placement.linear().determinant() < 0;
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) continue;  // points and lines enclose nothing
    std::array<int, 3> corners;
    for (unsigned k = 0; k < 3; ++k) corners[k] = first + static_cast<int>(face.mIndices[k]);
    if (mirrored) std::swap(corners[1], corners[2]);
    mesh.triangles.push_back(corners);
  }
}

void appendNode(const aiScene& scene, const aiNode& node, const Affine3d& parent, TriangleMesh& mesh) {
  const Affine3d placement = parent * toEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) appendMesh(*scene.mMeshes[node.mMeshes[i]], placement, mesh);
  for (unsigned i = 0; i < node.mNumChildren; ++i) appendNode(scene, *node.mChildren[i], placement, mesh);
}

struct Header {
  std::size_t vertices, triangles;
  double unit;
};
constexpr std::size_t kVertex = 3 * sizeof(double), kTriangle = 3 * sizeof(int);  // in bytes

std::size_t sizeOf(const Header& header) {
  return sizeof header + header.vertices * kVertex + header.triangles * kTriangle;
}

}  // namespace

MeshWithUnit importMesh(const std::string& path, const std::string& text, const Vector3d& scale) {
  Assimp::Importer importer;
  importer.SetIOHandler(new OneFile(path, text));  // the importer deletes it
  // Without this, the root node turns Z_UP and X_UP to Y_UP; it always has the unit, and nothing else.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // Without this, a scene without geometry gets triangles that stand for its nodes.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
  if (!scene || !scene->mRootNode) throw std::runtime_error(importer.GetErrorString());
  if (const std::size_t triangles = trianglesOf(*scene, *scene->mRootNode); triangles > kMaxTriangles)
    throw std::runtime_error("it has " + std::to_string(triangles) + " triangles, more than " +
                             std::to_string(kMaxTriangles));
  MeshWithUnit read{{}, scene->mRootNode->mTransformation.a1};
  appendNode(*scene, *scene->mRootNode, Affine3d(Eigen::Scaling(scale)), read.mesh);
  return read;
}

std::string toBytes(const MeshWithUnit& read) {
  const TriangleMesh& mesh = read.mesh;
  const Header header{mesh.vertices.size(), mesh.triangles.size(), read.unit};
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  bytes.reserve(sizeOf(header));
  for (const Vector3d& vertex : mesh.vertices) bytes.append(reinterpret_cast<const char*>(vertex.data()), kVertex);
  for (const auto& triangle : mesh.triangles) bytes.append(reinterpret_cast<const char*>(triangle.data()), kTriangle);
  return bytes;
}

MeshWithUnit meshFromBytes(const std::string& bytes) {
  Header header{};
  if (bytes.size() >= sizeof header) std::memcpy(&header, bytes.data(), sizeof header);
  // The counts are checked first, so that no product of them overflows.
  if (header.triangles > kMaxTriangles || header.vertices > 3 * kMaxTriangles || bytes.size() != sizeOf(header)) {
    throw std::runtime_error("what was read of it is no mesh");
  }
  TriangleMesh mesh{std::vector<Vector3d>(header.vertices), std::vector<std::array<int, 3>>(header.triangles)};
  const char* next = bytes.data() + sizeof header;
  for (Vector3d& vertex : mesh.vertices) {
    std::memcpy(vertex.data(), next, kVertex);
    next += kVertex;
  }
  for (std::array<int, 3>& triangle : mesh.triangles) {
    std::memcpy(triangle.data(), next, kTriangle);
    next += kTriangle;
    for (const int corner : triangle) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= header.vertices) {
        throw std::runtime_error("a triangle has a corner that is no vertex");
      }
    }
  }
  return {std::move(mesh), header.unit};
}

std::size_t maxBytesOfMesh() { return sizeOf({3 * kMaxTriangles, kMaxTriangles, 1.0}); }

}  // namespace proximity_server::scene
