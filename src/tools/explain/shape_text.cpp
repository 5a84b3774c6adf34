#include "tools/explain/shape_text.h"

#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;

/// The words of a text, one after the other.
class Words {
 public:
  Words(std::string what, const std::string& text) : what_(std::move(what)) {
    std::istringstream stream(text);
    for (std::string word; stream >> word;) words_.push_back(word);
  }

  bool hasMore() const { return next_ < words_.size(); }
  std::size_t left() const { return words_.size() - next_; }
  std::string word() { return words_.at(next_++); }

  double number(bool is_angle = false) {
    const std::string text = word();
    const std::optional<system::PositionText> value = system::positionIn(text);
    if (!value || (value->is_in_degrees && !is_angle)) fail("'" + text + "' is no finite number");
    return value->value;
  }
  Vector3d vector() {
    const double x = number(), y = number();
    return {x, y, number()};
  }

  [[noreturn]] void fail(const std::string& why) const { throw std::invalid_argument(what_ + ": " + why); }

 private:
  std::string what_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

struct ShapeKind {
  std::size_t count;
  const char* numbers;
  std::function<Shape(Words&)> read;
};

/// A shape of two numbers: its radius, and its length along z.
template <typename Solid>
Shape lengthwise(Words& words) {
  return Solid{words.number(), words.number()};  // in this order
}

/// The kinds that have a fixed count of numbers.
const std::map<std::string, ShapeKind>& kinds() {
  static const std::map<std::string, ShapeKind> kKinds{
      {"box", {3, "x y z", [](Words& words) { return narrowphase::Box{words.vector()}; }}},
      {"sphere", {1, "radius", [](Words& words) { return narrowphase::Sphere{words.number()}; }}},
      {"capsule", {2, "radius length", lengthwise<narrowphase::Capsule>}},
      {"cylinder", {2, "radius length", lengthwise<narrowphase::Cylinder>}},
      {"cone", {2, "radius length", lengthwise<narrowphase::Cone>}},
      {"ellipsoid", {3, "rx ry rz", [](Words& words) { return narrowphase::Ellipsoid{words.vector()}; }}},
  };
  return kKinds;
}

/// Throws if fewer than `count` words follow.
void require(const Words& words, std::size_t count, const std::string& name, const std::string& numbers) {
  if (words.left() >= count) return;
  words.fail(name + " needs " + std::to_string(count) + (count == 1 ? " number (" : " numbers (") + numbers +
             "), not " + std::to_string(words.left()));
}

std::vector<Vector3d> readPoints(Words& words) {
  constexpr double kMost = 1e6;
  require(words, 1, "hull", "how many points, then x y z of each");
  const double count = words.number();
  if (!(count >= 1.0 && count <= kMost) || count != std::floor(count)) words.fail("a hull of 1 to 1000000 points");
  std::vector<Vector3d> points(static_cast<std::size_t>(count));
  require(words, 3 * points.size(), "hull of " + std::to_string(points.size()), "x y z of each point");
  for (Vector3d& point : points) point = words.vector();
  return points;
}

/// The words of a text of `count` numbers. Throws if there are more or less words.
Words numberWords(const std::string& what, const std::string& text, std::size_t count) {
  Words words(what, text);
  if (words.left() != count) {
    words.fail("'" + text + "' has " + std::to_string(words.left()) + " numbers, not " + std::to_string(count));
  }
  return words;
}

constexpr std::size_t kPoseNumbers = 12;

/// The pose of the next kPoseNumbers words: rotation row by row, translation.
Isometry3d readPose(Words& words) {
  constexpr double kNoRotation = 1e-6;
  Isometry3d pose = Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) pose.linear().row(row) = words.vector().transpose();
  pose.translation() = words.vector();
  const Eigen::Matrix3d rotation = pose.linear();
  if ((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() > kNoRotation ||
      rotation.determinant() < 0.0) {
    words.fail("the first nine numbers are no rotation matrix");
  }
  return pose;
}

ExplainedShape readCore(Words& words) {
  if (!words.hasMore()) words.fail("empty; expected a shape, as \"box 1 2 3\"");
  const std::string name = words.word();
  if (name == "hull") {
    const std::vector<Vector3d> points = readPoints(words);
    return {narrowphase::ConvexHull(points),
            "hull of " + std::to_string(points.size()) + (points.size() == 1 ? " point" : " points"), points};
  }
  const auto kind = kinds().find(name);
  if (kind == kinds().end()) {
    words.fail("'" + name + "' is none of box, sphere, capsule, cylinder, cone, ellipsoid, hull");
  }
  require(words, kind->second.count, name, kind->second.numbers);
  return {kind->second.read(words), name, {}};
}

/// Reads the words behind the core.
void readMore(Words& words, ExplainedShape& read) {
  while (words.hasMore()) {
    const std::string word = words.word();
    if (word == "pad") {
      require(words, 1, word, "metres");
      read.shape = read.shape.padded(words.number());
      read.description += ", padded";
    } else if (word == "sweep") {
      require(words, kPoseNumbers, word, "rotation row by row, translation");
      read.shape = read.shape.sweptTo(readPose(words));
      read.description += ", swept";
    } else {
      words.fail("'" + word + "' is one word too many");
    }
  }
}

}  // namespace

std::vector<double> numbersOf(const std::string& what, const std::string& text, std::size_t count, bool are_angles) {
  Words words = numberWords(what, text, count);
  std::vector<double> numbers;
  while (words.hasMore()) numbers.push_back(words.number(are_angles));
  return numbers;
}

ExplainedShape readShape(const std::string& what, const std::string& text) {
  return naming(what, [&] {
    Words words(what, text);
    ExplainedShape read = readCore(words);
    readMore(words, read);
    return read;
  });
}

Isometry3d poseOf(const Vector3d& xyz, const Vector3d& rpy) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = xyz;
  pose.linear() = (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
                   Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

Isometry3d readPose(const std::string& what, const std::string& text) {
  Words words = numberWords(what, text, kPoseNumbers);
  return readPose(words);
}

}  // namespace proximity_server::tools
