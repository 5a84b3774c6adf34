#include "proximity_server/scene/objects/object.h"

#include "proximity_server/scene/model/names.h"
#include "scene/mesh/input_limits.h"
#include "scene/mesh/mesh_file.h"
#include "scene/model/body_pose.h"
#include "scene/model/pieces.h"
#include "scene/objects/object_geometry.h"
#include "system/number_text.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;

/// The convex shapes that represent one shape of an object.
struct ConvexParts {
  ObjectShapeInfo info;
  std::vector<Piece> parts;  ///< in the frame of the shape, without padding
  std::vector<HalfSpace> half_spaces;
  std::vector<std::string> warnings;
};

std::string nameOf(Shape::Kind kind, double margin) {
  switch (kind) {
    case Shape::Kind::Point:
      return "sphere";
    case Shape::Kind::Segment:
      return "capsule";
    case Shape::Kind::Box:
      return margin > 0.0 ? "rounded box" : "box";
    case Shape::Kind::Cylinder:
      return "cylinder";
    case Shape::Kind::Cone:
      return "cone";
    case Shape::Kind::Ellipsoid:
      return "ellipsoid";
    case Shape::Kind::Hull:
      return "convex hull";
    case Shape::Kind::Sweep:
      return "sweep";
  }
  return "shape";
}

/// Turns the geometry of one shape into convex parts.
class PartsReader {
 public:
  explicit PartsReader(const ObjectOptions& options) : options_(options) {}

  ConvexParts operator()(const Shape& shape) const {
    ConvexParts parts;
    parts.info.description = nameOf(shape.kind(), shape.margin());
    parts.parts.push_back({shape, Isometry3d::Identity(), 0});
    return parts;
  }

  ConvexParts operator()(const Boxes& boxes) const {
    ConvexParts parts;
    parts.info.description = std::to_string(boxes.boxes.size()) + " boxes";
    if (boxes.boxes.empty()) throw std::invalid_argument("there are no boxes");
    if (boxes.boxes.size() > kMaxPieces) throw std::invalid_argument("there are more than a million boxes");
    parts.parts.reserve(boxes.boxes.size());
    for (std::size_t i = 0; i < boxes.boxes.size(); ++i) {
      try {
        const Eigen::AlignedBox3d& box = boxes.boxes[i];
        if (!box.center().allFinite()) throw std::invalid_argument("its place is not finite");
        const Isometry3d place(Eigen::Translation3d(box.center()));
        parts.parts.push_back({narrowphase::Box{box.sizes()}, place, 0});
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument("box " + std::to_string(i + 1) + ": " + error.what());
      }
    }
    return parts;
  }

  ConvexParts operator()(const TriangleMesh& mesh) const {
    if (mesh.triangles.empty()) throw std::invalid_argument("the mesh has no triangle");
    return ofMesh(mesh, "mesh of " + std::to_string(mesh.triangles.size()) + " triangles");
  }

  ConvexParts operator()(const MeshFile& file) const {
    if (!options_.resolve) throw std::invalid_argument("there is no resolver for mesh " + file.uri);
    const MeshWithUnit read = readMesh(options_.resolve(file.uri), file.scale, options_.meshes.stop);
    return ofMesh(read.mesh, "mesh " + file.uri, unitRemark(read.unit));
  }

  ConvexParts operator()(const HalfSpace& half_space) const {
    if (!half_space.normal.allFinite() || half_space.normal.isZero(0.0) || !std::isfinite(half_space.offset))
      throw std::invalid_argument("the normal of the half-space is zero, or not finite, or its offset is not finite");
    const Vector3d scaled = half_space.normal / half_space.normal.cwiseAbs().maxCoeff();  // its square is in range
    ConvexParts parts;
    parts.info.description = "half-space";
    parts.half_spaces.push_back({scaled.normalized(), half_space.offset});
    return parts;
  }

 private:
  ConvexParts ofMesh(const TriangleMesh& mesh, const std::string& description, const std::string& unit = "") const {
    MeshPieces pieces = convexPieces(mesh, options_.meshes);
    if (pieces.hulls.empty()) throw std::invalid_argument(description + " has no geometry");
    ConvexParts parts;
    parts.info = {description, pieces.representation, pieces.deviation, pieces.uncovered, pieces.volume_ratio};
    parts.warnings = pieces.warnings;
    for (const std::string& text : {unit, pieces.shortfall, pieces.openness})
      if (!text.empty()) parts.warnings.push_back(description + ": " + text);
    for (std::size_t i = 0; i < pieces.hulls.size(); ++i)
      parts.parts.push_back({std::move(pieces.hulls[i]), Isometry3d::Identity(), 0, pieces.is_representative[i]});
    parts.parts.front().interior = std::move(pieces.interior);
    return parts;
  }

  const ObjectOptions& options_;
};

/// The parts of all shapes of an object together.
struct Parts {
  std::vector<Piece> pieces;
  std::vector<double> chain_lengths;  ///< [m] of the pieces
  std::vector<PlacedHalfSpace> half_spaces;
  std::vector<ObjectShapeInfo> shapes;
  std::vector<std::string> warnings;
};

/// [m] From the frame of an object. Objects around a robot are nearer, but not if they are in millimetres.
constexpr double kOddlyFar = 100.0;

void add(const ObjectShape& shape, const ObjectOptions& options, Parts& all) {
  const auto pose = usablePose(shape.object_T_shape);
  if (!pose) throw std::invalid_argument("its pose is not finite, or no rotation");
  ConvexParts parts = std::visit(PartsReader(options), shape.geometry);
  const int index = static_cast<int>(all.shapes.size());
  if (all.pieces.size() + parts.parts.size() > kMaxPieces)
    throw std::invalid_argument("the object has more than a million convex pieces");
  for (Piece& piece : parts.parts) {
    if (options.padding != 0.0) piece.shape = piece.shape.padded(options.padding);
    all.chain_lengths.push_back(pose->translation().norm() + piece.body_T_piece.translation().norm() +
                                piece.shape.coreReach() + piece.shape.margin());
    piece.body_T_piece = *pose * piece.body_T_piece;
    piece.collision = index;
    requireNear(piece, "the object");
    if (piece.shape.kind() == Shape::Kind::Hull) parts.info.vertices += piece.shape.hull().size();
    all.pieces.push_back(std::move(piece));
  }
  const auto lengths = all.chain_lengths.end() - static_cast<std::ptrdiff_t>(parts.parts.size());
  const auto farthest = std::max_element(lengths, all.chain_lengths.end());
  if (farthest != all.chain_lengths.end() && *farthest > kOddlyFar) {
    std::string warning = "shape " + std::to_string(index + 1) + " reaches ";
    system::appendRounded(warning, *farthest, 3);
    all.warnings.push_back(warning + " m from the frame of the object: are its numbers in millimetres?");
  }

  for (const HalfSpace& half_space : parts.half_spaces) {
    const Vector3d normal = (pose->linear() * half_space.normal).normalized();
    const double offset = half_space.offset + normal.dot(pose->translation()) + options.padding;
    if (!(std::abs(offset) <= kFarthest))
      throw std::invalid_argument(std::string("its plane is ") + kTooFar + " from the frame of the object");
    const double chain_length = std::abs(half_space.offset) + pose->translation().norm() + std::abs(options.padding);
    all.half_spaces.push_back({normal, offset, index, chain_length});
  }
  all.shapes.push_back(parts.info);
  all.shapes.back().pieces = static_cast<int>(parts.parts.size() + parts.half_spaces.size());
  for (const std::string& warning : parts.warnings) {  // only once, even if several shapes have the same mesh
    const std::string sentence = warning + ".";
    if (std::find(all.warnings.begin(), all.warnings.end(), sentence) == all.warnings.end())
      all.warnings.push_back(sentence);
  }
}

}  // namespace

Object makeObject(const std::string& id, std::vector<ObjectShape> shapes, const Placement& placement,
                  const ObjectOptions& options) {
  const std::string where = "object " + quoted(id) + ": ";
  if (shapes.empty()) throw std::invalid_argument(where + "it has no shape");
  if (!std::isfinite(options.padding)) throw std::invalid_argument(where + "its padding is not finite");
  Parts all;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    try {
      add(shapes[i], options, all);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(where + "shape " + std::to_string(i + 1) + ": " + error.what());
    }
  }
  for (std::string& warning : all.warnings) warning = where + warning;
  const auto source = std::make_shared<const ObjectSource>(ObjectSource{std::move(shapes), options.padding});
  return {id,
          std::make_shared<const ObjectGeometry>(source, std::move(all.pieces), std::move(all.chain_lengths),
                                                 std::move(all.half_spaces), std::move(all.shapes),
                                                 std::move(all.warnings)),
          placement};
}

const std::vector<ObjectShape>& givenShapesOf(const Object& object) { return object.geometry->source().shapes; }
double paddingOf(const Object& object) { return object.geometry->source().padding; }

const std::vector<ObjectShapeInfo>& shapesOf(const Object& object) { return object.geometry->shapes(); }
const std::vector<Piece>& piecesOf(const Object& object) { return object.geometry->pieces(); }
bool hasHalfSpace(const Object& object) { return !object.geometry->halfSpaces().empty(); }
const std::vector<std::string>& warningsOf(const Object& object) { return object.geometry->warnings(); }

}  // namespace proximity_server::scene
