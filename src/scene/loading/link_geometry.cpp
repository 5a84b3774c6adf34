#include "scene/loading/link_geometry.h"

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/names.h"
#include "scene/loading/collision_geometry.h"
#include "scene/mesh/input_limits.h"
#include "scene/model/pieces.h"
#include "system/append.h"

#include <algorithm>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

void requireLink(const std::string& what, const std::string& link, const RobotModel& model) {
  if (model.findLink(link) < 0)
    throw std::invalid_argument(what + ": no link " + unknownName(link, namesOf(model.links)));
}

MeshOptions meshOptionsOf(const std::string& link, const ModelOptions& options) {
  MeshOptions meshes;
  meshes.tolerance = options.meshToleranceOf(link);
  meshes.cache = options.mesh_cache;
  meshes.time_budget = options.mesh_time_budget;
  meshes.stop = options.stop;
  if (options.progress) {
    meshes.progress = [link, tell = options.progress](const std::string& what) {
      tell("link " + quoted(link) + ": " + what);
    };
  }
  return meshes;
}

/// The place of a <collision> in the URDF, or of a <visual> in its place.
struct Place {
  std::string link;
  int number;  ///< counted from 1 within its link
  bool is_visual;

  std::string text() const {
    return "link " + quoted(link) + ", <collision> " + std::to_string(number) + (is_visual ? ", of its <visual>" : "");
  }
};

/// Collects warnings about <collision> elements. The same warning about several elements, such as those with the same
/// mesh, becomes one sentence.
class GeometryWarnings {
 public:
  /// Adds a warning about a place, or, without a place, about the whole robot. The sentence has no full stop.
  void add(const std::string& sentence, const std::optional<Place>& place = std::nullopt) {
    const auto is_same = [&](const Entry& entry) { return entry.sentence == sentence; };
    auto entry = std::find_if(entries_.begin(), entries_.end(), is_same);
    if (entry == entries_.end()) entry = entries_.insert(entry, {sentence, {}});
    if (place) entry->places.push_back(*place);
  }

  /// The sentences in the order in which they were added.
  std::vector<std::string> sentences() const {
    std::vector<std::string> result;
    for (const auto& [sentence, places] : entries_) {
      const std::string where = places.size() == 1 ? places.front().text() : severalOf(places);
      result.push_back(where + (where.empty() ? "" : ": ") + sentence + ".");
    }
    return result;
  }

 private:
  struct Entry {
    std::string sentence;
    std::vector<Place> places;
  };

  static std::string severalOf(const std::vector<Place>& places) {
    if (places.empty()) return "";
    std::vector<std::string> links;
    for (const Place& place : places)
      if (links.empty() || links.back() != quoted(place.link)) links.push_back(quoted(place.link));
    return std::to_string(places.size()) + " <collision> elements of the " + (links.size() == 1 ? "link " : "links ") +
           listed(links);
  }

  std::vector<Entry> entries_;
};

/// Returns the lines of YAML that change what a mesh became whose time budget was spent; "" for all others.
std::string remedyOf(const MeshPieces& mesh, const std::string& link, const MeshOptions& options) {
  if (mesh.shortfall.empty()) return "";
  constexpr double kLongest = 3600.0, kLonger = 4.0;
  std::ostringstream text;
  text << "; \"mesh_time_budget: " << std::min(kLongest, kLonger * options.time_budget) << "\" lets it take longer";
  if (mesh.tolerance > options.tolerance)
    text << ", \"link_mesh_tolerance: {" << yamlName(link) << ": " << mesh.tolerance << "}\" asks for no more";
  return text.str();
}

/// Reads the geometry of one <collision>. If a mesh cannot be read and that is allowed, adds a warning and returns no
/// geometry.
CollisionGeometry readGeometry(const urdf::Geometry& geometry, const Place& place, const ModelOptions& options,
                               GeometryReader& reader, GeometryWarnings& warnings) {
  try {
    const MeshOptions meshes = meshOptionsOf(place.link, options);
    CollisionGeometry result = reader.read(geometry, meshes);
    for (const std::string& warning : result.mesh.warnings) warnings.add(warning);
    const std::string shortfall = result.mesh.shortfall + remedyOf(result.mesh, place.link, meshes);
    for (const std::string& text : {result.unit_remark, shortfall, result.mesh.openness})
      if (!text.empty()) warnings.add(text, place);
    return result;
  } catch (const std::invalid_argument& error) {
    const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry);
    if (mesh && mesh->filename.find("$(") != std::string::npos)
      throw std::invalid_argument(error.what() +
                                  std::string(": this is a xacro file; run xacro on it and take the URDF "
                                              "that it prints"));
    if (!mesh || !options.allow_missing_meshes) throw;
    warnings.add(std::string("no geometry: ") + error.what(), place);
    return {"mesh " + mesh->filename + ", missing", {}};
  }
}

/// [m] The diagonal of the box around a mesh. No link of a robot is that large, but a link of 2 cm is if its mesh is in
/// millimetres.
constexpr double kOddlyLarge = 20.0;

void warnOfMillimetres(const urdf::Geometry& urdf, const CollisionGeometry& geometry, const Place& place,
                       GeometryWarnings& warnings) {
  if (!dynamic_cast<const urdf::Mesh*>(&urdf)) return;
  Eigen::AlignedBox3d box;
  for (const narrowphase::Shape& shape : geometry.shapes) {
    for (const Vector3d& vertex : shape.hull().vertices()) box.extend(vertex);
  }
  const double size = geometry.shapes.empty() ? 0.0 : box.diagonal().norm();
  if (size < kOddlyLarge) return;
  std::ostringstream text;
  text << geometry.description << " is " << size << " m across. If it is in millimetres, it needs "
       << "scale=\"0.001 0.001 0.001\"";
  warnings.add(text.str(), place);
}

/// The end of each error about a <visual>, of which the mesh is often finer than what can be checked.
constexpr char kCureOfVisual[] =
    ". Give the link a coarser <visual> or a <collision> of its own, or leave it out of collision_from_visual";

/// Adds one <collision> and the pieces that stand for it alone.
void addCollision(int link, const urdf::Collision& urdf, bool is_visual, const ModelOptions& options,
                  GeometryReader& reader, GeometryWarnings& warnings, RobotModel& model) {
  Link& owner = model.links[link];
  const int number = static_cast<int>(owner.collisions.size()) + 1;
  const Place place{owner.name, number, is_visual};
  try {
    CollisionGeometry geometry = readGeometry(*urdf.geometry, place, options, reader, warnings);
    warnOfMillimetres(*urdf.geometry, geometry, place, warnings);
    if (is_visual) geometry.description += ", of its <visual>";
    const Isometry3d body_T_collision = owner.body_T_link * toEigen(urdf.origin);
    if (!body_T_collision.matrix().allFinite()) throw std::invalid_argument("its pose is not finite");
    if (model.collisions.size() == kMaxCollisions || model.pieces.size() + geometry.shapes.size() > kMaxPieces) {
      throw std::invalid_argument("the robot has more than 20000 <collision> elements, or a million convex pieces");
    }

    Collision collision{urdf.name, geometry.description,         link,
                        number,    geometry.mesh.representation, geometry.mesh.deviation,
                        {},        geometry.mesh.uncovered,      geometry.mesh.volume_ratio,
                        is_visual};
    const int index = static_cast<int>(model.collisions.size());
    for (std::size_t i = 0; i < geometry.shapes.size(); ++i) {
      Piece piece{geometry.shapes[i].padded(options.paddingOf(owner.name)), body_T_collision, index};
      if (!geometry.mesh.is_representative.empty()) piece.is_representative = geometry.mesh.is_representative[i];
      if (i == 0) piece.interior = geometry.mesh.interior;
      collision.pieces.push_back(system::append(model.pieces, std::move(piece)));
      requireNear(model.pieces.back(), "its body");
    }
    owner.collisions.push_back(system::append(model.collisions, std::move(collision)));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("URDF: " + place.text() + ": " + error.what() + (is_visual ? kCureOfVisual : ""));
  }
}

/// Adds the pieces of a link to its body: the pieces of its collisions, but a capsule instead of the three parts that
/// form it.
void addPiecesToBody(int link, const std::vector<CapsuleParts>& capsules, const ModelOptions& options,
                     RobotModel& model) {
  const Link& owner = model.links[link];
  std::vector<int>& body_pieces = model.bodies[owner.body].pieces;
  std::set<int> replaced;
  for (const CapsuleParts& parts : capsules) {
    const int index = owner.collisions[parts.cylinder];
    Collision& cylinder = model.collisions[index];
    const Isometry3d body_T_capsule = model.pieces[cylinder.pieces.front()].body_T_piece;
    const narrowphase::Shape padded = narrowphase::Shape(parts.capsule).padded(options.paddingOf(owner.name));
    body_pieces.push_back(system::append(model.pieces, Piece{padded, body_T_capsule, index}));
    cylinder.description += ", a capsule with <collision> " + std::to_string(parts.spheres[0] + 1) + " and " +
                            std::to_string(parts.spheres[1] + 1);
    replaced.insert({parts.cylinder, parts.spheres[0], parts.spheres[1]});
  }
  for (int i = 0; i < static_cast<int>(owner.collisions.size()); ++i) {
    if (replaced.count(i)) continue;
    const std::vector<int>& pieces = model.collisions[owner.collisions[i]].pieces;
    body_pieces.insert(body_pieces.end(), pieces.begin(), pieces.end());
  }
}

void readMeshesAhead(const urdf::ModelInterface& urdf, const ModelOptions& options, const RobotModel& model,
                     GeometryReader& reader) {
  std::vector<MeshRequest> requests;
  for (const Link& link : model.links) {
    for (const auto& collision : urdf.getLink(link.name)->collision_array) {
      if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(collision->geometry.get()))
        requests.push_back({mesh, meshOptionsOf(link.name, options)});
    }
  }
  using Failure = GeometryReader::Failure;
  reader.readAhead(requests, options.threads, options.allow_missing_meshes ? Failure::IsPassedOver : Failure::EndsIt);
}

}  // namespace

void requireLinks(const ModelOptions& options, const RobotModel& model) {
  for (const auto& [link, padding] : options.link_padding) requireLink("link_padding", link, model);
  for (const auto& [link, tolerance] : options.link_mesh_tolerance) requireLink("link_mesh_tolerance", link, model);
  for (const std::string& link : options.collision_from_visual)
    if (link != kAllLinks) requireLink("collision_from_visual", link, model);
}

void addGeometry(const urdf::ModelInterface& urdf, const MeshResolver& resolve, const ModelOptions& options,
                 const FromVisual& visuals, RobotModel& model) {
  GeometryReader reader(resolve);
  readMeshesAhead(urdf, options, model, reader);
  GeometryWarnings warnings;
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link) {
    const auto& collisions = urdf.getLink(model.links[link].name)->collision_array;
    const bool are_visual = visuals.taken.count(model.links[link].name) > 0;
    for (const auto& collision : collisions)
      addCollision(link, *collision, are_visual, options, reader, warnings, model);
    addPiecesToBody(link, findCapsules(collisions), options, model);
  }
  for (std::string& warning : warnings.sentences()) model.warnings.push_back(std::move(warning));
  if (model.pieces.empty()) model.warnings.push_back("No link of the robot has collision geometry.");
}

}  // namespace proximity_server::scene
