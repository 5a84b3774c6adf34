#pragma once

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/objects/object_editor.h"
#include "proximity_server/scene/objects/object_rules.h"
#include "proximity_server/scene/objects/objects.h"

#include <Eigen/Geometry>

#include <string>
#include <variant>
#include <vector>

// Objects in the form of files and parameters, before a robot is known. The fields have the names of ObjectChange.msg;
// config/README.md describes the format.

namespace proximity_server::scene {

/// A rule for a pair of names. The last rule that names a pair decides, see AllowedPairs.
struct WrittenRule {
  std::string a, b;
  AllowedPairs::Rule rule = AllowedPairs::Rule::Allowed;
};

/// The objects with these rules for pairs. Their other rules stay.
Objects withRules(const Objects& objects, const std::vector<WrittenRule>& rules);

/// The moment of a change: before the state with this number, counted from 0, or at a time [s] of the states.
struct AtRow {
  long row = 0;
};
struct AtTime {
  double time = 0.0;
};
using Moment = std::variant<AtRow, AtTime>;

/// A change during a sequence of recorded or planned states. Detach always leaves the object where it is.
struct WrittenChange {
  Moment at;
  ObjectEdit edit;
};

/// Places are in the frames that carry the objects. The shapes of the format are box, sphere, cylinder and cone without
/// margin, Boxes, also of a cloud in a file, TriangleMesh, MeshFile, and HalfSpace.
struct ObjectFile {
  std::vector<ObjectEdit> objects;  ///< the objects that are added
  std::vector<WrittenRule> rules;
  std::vector<WrittenChange> changes;   ///< in the order in which they are made
  std::vector<std::string> warnings{};  ///< with source, line and field
};

/// Reads a list of objects, or a map of `objects`, `rules` and `changes`. If the plain path of a mesh is relative, it
/// begins in `folder` and becomes an absolute path.
///
/// Failure: throws std::invalid_argument with `source`, the line, the field with the id of its object, and the reason:
///          a field that is unknown, missing or of the wrong type; a number that is not finite; a size that is not
///          positive; a URI with a scheme other than package:// and file://; a relative path without a folder;
///          different numbers of poses and shapes; a change that comes before the change above it.
ObjectFile objectFileFrom(const FileValue& value, const std::string& source, const std::string& folder = {});

/// Reads the text that MoveIt's RViz plugin writes and reads (.scene), with and without poses and subframes of objects.
/// Subframes and colours are ignored. Poses are in the frame of the answers. A plane is the half-space a x + b y + c z
/// + d <= 0.
///
/// Failure: throws std::invalid_argument with `source`, the line, the object and the reason; an octree is refused.
ObjectFile readMoveitScene(const std::string& text, const std::string& source);

/// Reads a file of at most 256 MiB: MoveIt's text if the name ends with ".scene", otherwise YAML. Relative paths of
/// meshes and clouds begin in its folder. The file of a cloud, see isCloudFile(), is an object with its name.
/// Failure: throws std::invalid_argument, naming the file, as the functions above, and if it cannot be read.
ObjectFile readObjectFile(const std::string& path);

/// Writes objects and rules as YAML. Reading it gives the same objects and rules; only the order of shapes of different
/// kinds may differ, and rotations and normals may differ by roundings.
/// The text is put together from strings, 0.15 s for a mesh of 200,000 triangles. libyaml's emitter takes as long, with a
/// call for each value and bracket; the emitter of yaml-cpp takes 6 times as long, and writes 0.1 as
/// 0.10000000000000001.
/// Failure: throws std::invalid_argument, naming the object, for a shape that the format does not have.
std::string yamlOf(const ObjectFile& file);

/// Throws std::invalid_argument if the text is not UTF-8: then no file can contain it.
void requireUtf8(const std::string& text);

}  // namespace proximity_server::scene
