#include "proximity_server/scene/mesh.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <assimp/Importer.hpp>
#include <filesystem>
#include <stdexcept>

namespace proximity_server {
namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw std::invalid_argument("mesh " + path + ": " + why);
}

Affine3d toEigen(const aiMatrix4x4& m) {
  Affine3d transform;
  transform.matrix() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, 0, 0, 0, 1;
  return transform;
}

void appendMesh(const aiMesh& part, const Affine3d& placement, TriangleMesh& mesh) {
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

}  // namespace

TriangleMesh loadMesh(const std::string& path, const Vector3d& scale) {
  if (!scale.allFinite() || (scale.array() == 0.0).any()) fail(path, "its scale must be finite and not zero");
  // Assimp would wait for ever on a pipe.
  if (std::error_code failed; !std::filesystem::is_regular_file(path, failed)) fail(path, "no such file");

  Assimp::Importer importer;
  // Else the root node turns Z_UP and X_UP to Y_UP; it always carries the unit.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // Else a scene without geometry gets triangles that stand for its nodes.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
  if (!scene || !scene->mRootNode) fail(path, importer.GetErrorString());

  TriangleMesh mesh;
  appendNode(*scene, *scene->mRootNode, Affine3d(Eigen::Scaling(scale)), mesh);
  if (mesh.triangles.empty()) fail(path, "it has no triangle");
  for (const Vector3d& vertex : mesh.vertices) {
    if (!vertex.allFinite()) fail(path, "a coordinate is not finite");
  }
  return mesh;
}

}  // namespace proximity_server
