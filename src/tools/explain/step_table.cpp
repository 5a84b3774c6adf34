#include "tools/explain/explanation.h"
#include "tools/explain/vertex_names.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace proximity_server::tools {
namespace {

using Eigen::Vector3d;
using narrowphase::CsoVertex;
using narrowphase::QueryTrace;
using Row = std::vector<std::string>;

constexpr int kPointDigits = 5, kBoundDigits = 9;

std::string rounded(double value, int digits) {
  if (std::isnan(value)) return "nan";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value + 0.0);  // no minus zero
  return text.data();
}

/// Coordinates that are rounding, beside the size of what is shown, are 0. A size that overflows tells nothing.
std::string pointText(const Vector3d& point, double size) {
  constexpr double kRounding = 1e-12;
  std::string text = "(";
  for (int i = 0; i < 3; ++i) {
    const double value = std::isfinite(size) && std::abs(point[i]) < kRounding * size ? 0.0 : point[i];
    text += (i == 0 ? "" : ", ") + rounded(value, kPointDigits);
  }
  return text + ")";
}

/// Rows below a heading, each column as wide as its widest field.
std::string aligned(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const Row& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - row[i].size(), ' ');
      line += "  " + (i == 0 ? space + row[i] : row[i] + space);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

class Table {
 public:
  explicit Table(const Explanation& explanation)
      : explanation_(explanation),
        names_(explanation.pair),
        margins_(explanation.pair.a.shape.margin() + explanation.pair.b.shape.margin()),
        size_(explanation.pair.a.shape.coreReach() + explanation.pair.b.shape.coreReach() +
              explanation.pair.a_T_b.translation().norm() + margins_) {}

  std::string text() {
    std::string text = "a: " + described(explanation_.pair.a) + "\nb: " + described(explanation_.pair.b) + "\n";
    const Eigen::Isometry3d& pose = explanation_.pair.a_T_b;
    const Eigen::AngleAxisd turn(pose.linear());
    text += "b lies at " + pointText(pose.translation(), size_) + " in the frame of a";
    if (turn.angle() > 0.0) {
      text += ", turned by " + rounded(turn.angle(), kPointDigits) + " rad about " + pointText(turn.axis(), 1.0);
    }
    text += ".\n";
    if (!explanation_.trace.gjk.empty()) text += gjk();
    if (!explanation_.trace.epa.empty()) text += epa();
    return text + answer();
  }

 private:
  static std::string described(const ExplainedShape& shape) {
    if (shape.shape.margin() == 0.0) return shape.description;
    return shape.description + " (core and a margin of " + rounded(shape.shape.margin(), kPointDigits) + " m)";
  }
  std::string point(const Vector3d& point) const { return pointText(point, size_); }
  std::string bound(double of_cores) const { return rounded(of_cores - margins_, kBoundDigits); }

  /// Names of the vertices of a simplex: A before B, w2 before w10.
  std::string inOrder(const std::vector<CsoVertex>& simplex) {
    std::vector<std::string> names;
    for (const CsoVertex& vertex : simplex) names.push_back(names_.nameOf(vertex));
    const auto isBefore = [](const std::string& a, const std::string& b) {
      return a.size() != b.size() ? a.size() < b.size() : a < b;
    };
    std::sort(names.begin(), names.end(), isBefore);
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
    return text;
  }

  std::string gjk() {
    std::vector<Row> rows{{"step", "vertex", "point of a", "point of b", "simplex", "nearest point", "lower", "upper"}};
    for (const QueryTrace::GjkStep& step : explanation_.trace.gjk) {
      const std::string name = names_.nameOf(step.w);  // first, as it may be a new one
      rows.push_back({std::to_string(rows.size()), name, point(step.w.on_a), point(step.w.onB()), inOrder(step.simplex),
                      step.simplex.empty() ? "" : point(step.nearest), bound(step.lower_bound),
                      bound(step.upper_bound)});
    }
    return "\nGJK: the point of the CSO, a - b, that is nearest to the origin\n" + aligned(rows);
  }

  std::string epa() {
    const QueryTrace& trace = explanation_.trace;
    std::vector<Row> rows{
        {"step", "faces", "closest face", "normal", "vertex", "point of a", "point of b", "lower", "upper"}};
    for (const QueryTrace::EpaStep& step : trace.epa) {
      std::string face;
      for (const int v : step.closest) face += (face.empty() ? "" : " ") + names_.nameOf(trace.polytope[v]);
      rows.push_back({std::to_string(rows.size()), std::to_string(step.faces.size()), face, pointText(step.normal, 1.0),
                      names_.nameOf(step.w), point(step.w.on_a), point(step.w.onB()), bound(-step.depth),
                      bound(-step.lower_bound)});
    }
    return "\nEPA: the face of the CSO that is closest to the origin inside\n" + aligned(rows);
  }

  std::string answer() const {
    const narrowphase::SignedDistance& answer = explanation_.answer;
    std::string text = "\nThe answer is by " + algorithmText(explanation_.trace.algorithm) + ".\n";
    if (answer.status == narrowphase::Status::Unknown) return text;
    text += "  distance  " + rounded(answer.distance, kBoundDigits) + " m, from " +
            rounded(answer.lower_bound, kBoundDigits) + " to " + rounded(answer.upper_bound, kBoundDigits) +
            " (width " + rounded(answer.upper_bound - answer.lower_bound, 2) + ")\n";
    text += "  normal    " + pointText(answer.normal, 1.0) + "\n";
    if (answer.has_points) {
      text += "  points    " + point(answer.point_a) + " of a, " + point(answer.point_b) + " of b\n";
    }
    return text + "  status    " + statusText(answer.status) + (answer.unique ? "" : ", one choice of many") + ", " +
           std::to_string(answer.iterations) + (answer.iterations == 1 ? " iteration\n" : " iterations\n");
  }

  const Explanation& explanation_;
  VertexNames names_;
  double margins_;  // [m]
  double size_;     // [m]
};

}  // namespace

std::string tableOf(const Explanation& explanation) { return Table(explanation).text(); }

}  // namespace proximity_server::tools
