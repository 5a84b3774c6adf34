#include "tools/explain/vertex_names.h"

#include <algorithm>

namespace proximity_server::tools {
namespace {

using Eigen::Vector3d;
using narrowphase::Shape;

constexpr int kLetters = 26;

bool hasNumberedPoints(const Shape& shape) { return shape.isPolytope() && shape.kind() != Shape::Kind::Sweep; }

int countOfPoints(const ExplainedShape& shape) {
  switch (shape.shape.kind()) {
    case Shape::Kind::Point:
      return 1;
    case Shape::Kind::Segment:
      return 2;
    case Shape::Kind::Box:
      return 8;
    default:
      return static_cast<int>(shape.points.size());
  }
}

/// Names a vertex by its number in the narrowphase, which numbers the corners of a box by their signs, and the ends of
/// a point and a segment, too.
int indexOf(const ExplainedShape& shape, int number) {
  switch (shape.shape.kind()) {
    case Shape::Kind::Point:
      return 0;
    case Shape::Kind::Segment:
      return number >> 2;
    case Shape::Kind::Box:
      return number;
    default:
      break;
  }
  const Vector3d& vertex = shape.shape.hull().vertices()[number];
  return static_cast<int>(std::find(shape.points.begin(), shape.points.end(), vertex) - shape.points.begin());
}

std::string letter(char first, int index) { return std::string(1, static_cast<char>(first + index)); }

std::string pointName(const ExplainedShape& shape, int number, char first_letter) {
  const int index = indexOf(shape, number);
  return countOfPoints(shape) > kLetters ? std::to_string(index) : letter(first_letter, index);
}

}  // namespace

std::string VertexNames::nameOf(const narrowphase::CsoVertex& vertex) {
  if (!hasNumberedPoints(pair_.a.shape) || !hasNumberedPoints(pair_.b.shape)) return inOrder(vertex.point);
  const int of_a = countOfPoints(pair_.a), of_b = countOfPoints(pair_.b);
  if (of_b == 1) return pointName(pair_.a, vertex.numbers.a, 'A');
  if (of_a == 1) return pointName(pair_.b, vertex.numbers.b, 'a');
  const char* separator = std::max(of_a, of_b) > kLetters ? "-" : "";
  return pointName(pair_.a, vertex.numbers.a, 'A') + separator + pointName(pair_.b, vertex.numbers.b, 'a');
}

std::string VertexNames::inOrder(const Vector3d& point) {
  const auto found = std::find(seen_.begin(), seen_.end(), point);
  const auto index = found - seen_.begin();
  if (found == seen_.end()) seen_.push_back(point);
  return "w" + std::to_string(index + 1);
}

std::vector<NamedPoint> namedPoints(const ExplainedPair& pair) {
  if (!hasNumberedPoints(pair.a.shape) || !hasNumberedPoints(pair.b.shape)) return {};
  if (countOfPoints(pair.b) != 1 || pair.a.points.size() > kLetters) return {};
  const Vector3d on_b = pair.a_T_b * (pair.b.points.empty() ? Vector3d(Vector3d::Zero()) : pair.b.points[0]);
  std::vector<NamedPoint> named;
  for (const Vector3d& point : pair.a.points) {
    named.push_back({letter('A', static_cast<int>(named.size())), point - on_b});
  }
  return named;
}

}  // namespace proximity_server::tools
