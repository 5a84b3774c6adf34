#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/object_files/object_file.h"

#include <iconv.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;

std::string listOf(std::initializer_list<double> numbers) {
  std::string list;
  for (const double number : numbers) list += (list.empty() ? "" : ", ") + shortest(number);
  return "[" + list + "]";
}
std::string listOf(const Vector3d& v) { return listOf({v.x(), v.y(), v.z()}); }

/// The Unicode characters of a text in UTF-8. Throws std::invalid_argument if it is not UTF-8: then a file cannot
/// contain it.
std::wstring charactersOf(const std::string& text) {
  std::wstring characters(text.size(), L'\0');  // each character has at least one byte
  char* from = const_cast<char*>(text.data());
  char* to = reinterpret_cast<char*>(characters.data());
  std::size_t unread = text.size(), room = characters.size() * sizeof(wchar_t);
  const iconv_t converter = iconv_open("WCHAR_T", "UTF-8");
  const bool is_read = iconv(converter, &from, &unread, &to, &room) != static_cast<std::size_t>(-1);
  iconv_close(converter);
  characters.resize(characters.size() - room / sizeof(wchar_t));
  const auto is_none = [](wchar_t character) { return character > 0x10FFFF; };
  if (!is_read || std::any_of(characters.begin(), characters.end(), is_none))
    throw std::invalid_argument("it is no text in UTF-8");
  return characters;
}

/// The text in quotes, and in ASCII. YAML reads back the same text, whatever it contains.
std::string quotedText(const std::string& text) {
  std::string result = "\"";
  for (const wchar_t character : charactersOf(text)) {
    const auto code = static_cast<unsigned>(character);
    if (code >= 0x20 && code < 0x7F) {
      if (code == '"' || code == '\\') result += "\\";
      result += static_cast<char>(code);
    } else {
      std::array<char, 16> escape{};
      std::snprintf(escape.data(), escape.size(), code <= 0xFFFF ? "\\u%04x" : "\\U%08x", code);
      result += escape.data();
    }
  }
  return result + "\"";
}

std::string poseText(const Isometry3d& pose) {
  std::string text = "{position: " + listOf(pose.translation());
  if (!pose.linear().isIdentity(0.0)) {
    const Eigen::Quaterniond q(pose.linear());
    text += ", orientation: " + listOf({q.x(), q.y(), q.z(), q.w()});
  }
  return text + "}";
}

std::string primitiveText(const char* type, std::initializer_list<double> dimensions) {
  return std::string("{type: ") + type + ", dimensions: " + listOf(dimensions) + "}";
}

/// The text of one shape.
struct ShapeText {
  std::string operator()(const Shape& shape) const {
    const Vector3d& half = shape.halfExtents();
    const bool is_sphere = shape.kind() == Shape::Kind::Point;
    if (shape.margin() != 0.0 && !is_sphere) throw std::invalid_argument("the format has no rounded shapes");
    switch (shape.kind()) {
      case Shape::Kind::Point:
        return primitiveText("SPHERE", {shape.margin()});
      case Shape::Kind::Box:
        return primitiveText("BOX", {2.0 * half.x(), 2.0 * half.y(), 2.0 * half.z()});
      case Shape::Kind::Cylinder:
        return primitiveText("CYLINDER", {2.0 * half.z(), half.x()});
      case Shape::Kind::Cone:
        return primitiveText("CONE", {2.0 * half.z(), half.x()});
      default:
        throw std::invalid_argument("the format has no shapes but boxes, spheres, cylinders, cones, meshes and planes");
    }
  }
  std::string operator()(const Boxes& boxes) const {
    const auto has_first_size = [&](const Eigen::AlignedBox3d& box) {
      return box.sizes() == boxes.boxes.front().sizes();
    };
    const bool same_size = std::all_of(boxes.boxes.begin(), boxes.boxes.end(), has_first_size);
    std::string centres, sizes;
    for (const Eigen::AlignedBox3d& box : boxes.boxes) {
      centres += (centres.empty() ? "" : ", ") + listOf(box.center());
      if (sizes.empty() || !same_size) sizes += (sizes.empty() ? "" : ", ") + listOf(box.sizes());
    }
    return "{centres: [" + centres + "],\n     sizes: [" + sizes + "]}";
  }
  std::string operator()(const TriangleMesh& mesh) const {
    std::string vertices, triangles;
    for (const Vector3d& vertex : mesh.vertices) vertices += (vertices.empty() ? "" : ", ") + listOf(vertex);
    for (const auto& [a, b, c] : mesh.triangles)
      triangles += (triangles.empty() ? "" : ", ") + ("{vertex_indices: [" + std::to_string(a)) + ", " +
                   std::to_string(b) + ", " + std::to_string(c) + "]}";
    return "{vertices: [" + vertices + "],\n     triangles: [" + triangles + "]}";
  }
  std::string operator()(const MeshFile& file) const {
    return "{uri: " + quotedText(file.uri) + ", scale: " + listOf(file.scale) + "}";
  }
  std::string operator()(const HalfSpace& plane) const {
    const Vector3d& n = plane.normal;
    return "{coef: " + listOf({n.x(), n.y(), n.z(), -plane.offset * n.norm()}) + "}";
  }
};

/// The lists of the shapes and poses of one object.
std::string shapesText(const std::vector<ObjectShape>& shapes) {
  std::string all;
  for (std::size_t kind = 0; kind < kShapeKinds.size(); ++kind) {
    std::string list, poses;
    bool has_poses = false;
    for (const ObjectShape& shape : shapes) {
      if (shape.geometry.index() != kind) continue;
      list += "  - " + std::visit(ShapeText(), shape.geometry) + "\n";
      poses += "  - " + poseText(shape.object_T_shape) + "\n";
      has_poses = has_poses || !shape.object_T_shape.isApprox(Isometry3d::Identity(), 0.0);
    }
    if (!list.empty()) all += std::string("  ") + kShapeKinds[kind].shapes + ":\n" + list;
    if (has_poses) all += std::string("  ") + kShapeKinds[kind].poses + ":\n" + poses;
  }
  return all;
}

std::string placeText(const ObjectPlace& place) {
  std::string text;
  if (!place.link.empty()) text += "  link: " + quotedText(place.link) + "\n";
  if (!place.touch_links.empty()) {
    std::string links;
    for (const std::string& link : place.touch_links) links += (links.empty() ? "" : ", ") + quotedText(link);
    text += "  touch_links: [" + links + "]\n";
  }
  if (!place.frame.empty()) text += "  frame: " + quotedText(place.frame) + "\n";
  return text + "  pose: " + poseText(place.pose) + "\n";
}

std::string objectText(const ObjectEdit& object) {
  return "- id: " + quotedText(object.id) + "\n" + placeText(object.place) +
         (object.padding > 0.0 ? "  padding: " + shortest(object.padding) + "\n" : "") + shapesText(object.shapes);
}

}  // namespace

void requireUtf8(const std::string& text) { charactersOf(text); }

std::string yamlOf(const ObjectFile& file) {
  std::string text = file.objects.empty() ? "objects: []\n" : "objects:\n";
  for (const ObjectEdit& object : file.objects) {
    try {
      text += objectText(object);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("object " + quoted(object.id) + ": " + error.what());
    }
  }
  if (!file.rules.empty()) text += "rules:\n";
  for (const WrittenRule& rule : file.rules) {
    const bool is_allowed = rule.rule == AllowedPairs::Rule::Allowed;
    text += "- {a: " + quotedText(rule.a) + ", b: " + quotedText(rule.b) +
            ", allowed: " + (is_allowed ? "true" : "false") + "}\n";
  }
  return text;
}

}  // namespace proximity_server::scene
