#pragma once

#include "proximity_server/narrowphase/cso/cso.h"
#include "tools/explain/explained_pair.h"

#include <string>
#include <vector>

namespace proximity_server::tools {

/// Names of the vertices of a CSO, for people.
///
/// The points of a polytope are A, B, ... on a, and a, b, ... on b, in the order in which a hull was given; where there
/// are more than 26, they are numbers. The vertex A - b of the CSO is "Ab", and "A" if b has one point only. On curved
/// and swept shapes the vertices are w1, w2, ... in the order in which they are asked for.
class VertexNames {
 public:
  /// The pair must outlive this.
  explicit VertexNames(const ExplainedPair& pair) : pair_(pair) {}

  std::string nameOf(const narrowphase::CsoVertex& vertex);

 private:
  std::string inOrder(const Eigen::Vector3d& point);

  const ExplainedPair& pair_;
  std::vector<Eigen::Vector3d> seen_;
};

/// The points of a as vertices of the CSO, inner ones too, where b is one point and a is a hull of few that is not
/// swept; else nothing.
struct NamedPoint {
  std::string name;
  Eigen::Vector3d point;
};
std::vector<NamedPoint> namedPoints(const ExplainedPair& pair);

}  // namespace proximity_server::tools
