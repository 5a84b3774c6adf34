#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "scene/files/field.h"
#include "system/number_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>

// The text format of MoveIt, as its RViz plugin exports it. It consists of words; names have lines of their own:
//
//   scene name
//   * id                        an object, to the end of the file or "."
//   x y z   qx qy qz qw         its pose; not in versions before subframes
//   number of shapes
//     sphere radius | box x y z | cylinder radius length | cone radius length | plane a b c d |
//     mesh (numbers of vertices and triangles) (x y z) ... (i j k) ...
//     x y z   qx qy qz qw       its pose, in the frame of the object, or of the scene if objects have no pose
//     r g b a
//   number of subframes         not in versions before subframes
//     name
//     x y z   qx qy qz qw
//   .
//
// Sources: the documentation of "Export As Text" in MoveIt's RViz plugin, and files that it wrote. The line after "*
//          id" tells the version: it holds either the position of the object, which contains spaces, or the number of
//          shapes, which contains none.

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr std::string_view kSpaces = " \t\r\f\v";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kSpaces);
  return begin == std::string_view::npos ? std::string_view()
                                         : text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

class SceneReader {
 public:
  SceneReader(const std::string& text, const std::string& source) : rest_(text), source_(source) {}

  ObjectFile read() {
    ObjectFile file;
    if (!rest_.empty() && rest_.front() != '\n') line();  // the name of the scene
    while (!isAtEnd()) {
      const std::string_view begin = line();
      if (begin.empty()) continue;  // the rest of the line before
      if (begin == ".") return file;
      if (begin.front() != '*') refuse("an object begins with * and its id, the scene ends with a dot");
      file.objects.push_back(object(std::string(trimmed(begin.substr(1)))));
      object_.clear();
    }
    refuse("it is cut off: the scene ends with a dot");
  }

 private:
  /// Returns make(arguments...). Its errors get the place in front.
  template <class Make, class... Arguments>
  auto checked(const Make& make, Arguments&&... arguments) const {
    return refusedBy([this](const std::string& reason) { refuse(reason); }, make,
                     std::forward<Arguments>(arguments)...);
  }

  ObjectEdit object(std::string id) {
    object_ = id;
    ObjectEdit result;
    result.id = std::move(id);
    result.source = place();
    const bool has_pose = trimmed(lineBehindThis()).find_first_of(kSpaces) != std::string_view::npos;
    if (has_pose) result.place.pose = pose();
    const long shapes = count("number of shapes");
    for (long i = 0; i < shapes; ++i) result.shapes.push_back(shape());
    checked(completeFields, result);
    if (has_pose) skipSubframes();
    return result;
  }

  ObjectShape shape() {
    ObjectShape shape{geometry()};
    shape.object_T_shape = pose();
    for (int i = 0; i < 4; ++i) number();  // the colour
    return shape;
  }

  decltype(ObjectShape::geometry) geometry() {
    const std::string_view kind = word();
    if (kind == "sphere") return checked(primitiveFrom, "SPHERE", numbers(1));
    if (kind == "box") return checked(primitiveFrom, "BOX", numbers(3));
    if (kind == "cylinder" || kind == "cone") {
      const double radius = number(), length = number();
      return checked(primitiveFrom, kind == "cone" ? "CONE" : "CYLINDER", std::vector<double>{length, radius});
    }
    if (kind == "plane") {
      const std::vector<double> n = numbers(4);
      return checked(halfSpaceFrom, n[0], n[1], n[2], n[3]);
    }
    if (kind == "mesh") return mesh();
    refuse(kind == "octree" ? "octrees are not read" : "there is no shape " + quoted(std::string(kind)));
  }

  TriangleMesh mesh() {
    const long vertex_count = count("number of vertices"), triangle_count = count("number of triangles");
    std::vector<Vector3d> vertices;
    std::vector<std::array<int, 3>> triangles;
    for (long i = 0; i < vertex_count; ++i) vertices.push_back(vector());
    for (long i = 0; i < triangle_count; ++i) {
      for (int& corner : triangles.emplace_back()) corner = static_cast<int>(count("vertex"));
    }
    return checked(meshFrom, std::move(vertices), std::move(triangles));
  }

  void skipSubframes() {
    const long subframes = count("number of subframes");
    for (long i = 0; i < subframes; ++i) {
      while (line().empty())
        if (isAtEnd()) refuse("it is cut off in the subframes");
      pose();
    }
  }

  Isometry3d pose() {
    const Vector3d position = vector();
    const std::vector<double> q = numbers(4);
    if (q == std::vector<double>(4)) refuse("the quaternion of a pose is zero");
    return poseFrom(position, {q[3], q[0], q[1], q[2]});
  }

  Vector3d vector() {
    const std::vector<double> n = numbers(3);
    return {n[0], n[1], n[2]};
  }

  std::vector<double> numbers(std::size_t count) {
    std::vector<double> numbers;
    while (numbers.size() < count) numbers.push_back(number());
    return numbers;
  }

  double number() {
    const std::string_view text = word();
    const std::optional<double> value = system::numberIn<double>(text);
    if (!value || !std::isfinite(*value)) refuse("a finite number is expected, not " + quoted(std::string(text)));
    return *value;
  }

  /// Reads a number of things, or the number of one thing.
  long count(const std::string& of) {
    const std::string_view text = word();
    const std::optional<long> value = system::numberIn<long>(text);
    if (!value || *value < 0 || *value > kMost) refuse("the " + of + " is expected, not " + quoted(std::string(text)));
    return *value;
  }
  static constexpr long kMost = 2'000'000'000;

  bool isAtEnd() const { return rest_.empty(); }

  std::string_view word() {
    while (!rest_.empty() && (rest_.front() == '\n' || kSpaces.find(rest_.front()) != std::string_view::npos)) {
      if (rest_.front() == '\n') ++line_;
      rest_.remove_prefix(1);
    }
    if (rest_.empty()) refuse("it is cut off");
    const std::string_view found = rest_.substr(0, rest_.find_first_of(" \t\r\f\v\n"));
    rest_.remove_prefix(found.size());
    return found;
  }

  /// The rest of this line, without spaces around it; if nothing is left, the next line.
  std::string_view line() {
    if (!rest_.empty() && rest_.front() == '\n') {
      rest_.remove_prefix(1);
      ++line_;
    }
    const std::string_view found = rest_.substr(0, rest_.find('\n'));
    rest_.remove_prefix(found.size());
    return trimmed(found);
  }

  std::string_view lineBehindThis() const {
    const std::string_view behind = rest_.substr(std::min<std::size_t>(1, rest_.size()));
    return behind.substr(0, behind.find('\n'));
  }

  std::string place() const {
    return source_ + ", line " + std::to_string(line_) + (object_.empty() ? "" : ": object " + quoted(object_));
  }

  [[noreturn]] void refuse(const std::string& reason) const { throw std::invalid_argument(place() + ": " + reason); }

  std::string_view rest_;
  const std::string& source_;
  std::string object_;  ///< the id of the object that is being read
  long line_ = 1;
};

}  // namespace

ObjectFile readMoveitScene(const std::string& text, const std::string& source) {
  return SceneReader(text, source).read();
}

}  // namespace proximity_server::scene
