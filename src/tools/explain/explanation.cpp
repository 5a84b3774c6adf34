#include "tools/explain/explanation.h"

#include "proximity_server/narrowphase/signed_distance.h"

namespace proximity_server::tools {

using narrowphase::Algorithm;
using narrowphase::Status;

Explanation explain(const ExplainedPair& pair, const narrowphase::Options& options,
                    const Eigen::Vector3d& first_direction) {
  narrowphase::WarmStart start;
  start.axis = first_direction;
  Explanation explanation{pair, {}, {}};
  explanation.answer = signedDistance(pair.a.shape, pair.b.shape, pair.a_T_b, options, start, explanation.trace);
  return explanation;
}

std::string algorithmText(Algorithm algorithm) {
  switch (algorithm) {
    case Algorithm::None:
      return "nothing: the pose is not finite, or lengths add up to more than 1e30 m";
    case Algorithm::PointsAndSegments:
      return "the closed form of points and segments, and of a point and a box";
    case Algorithm::ParallelAxes:
      return "the closed form of solids of revolution about parallel axes";
    case Algorithm::FirstDirection:
      return "the first vertex of the CSO, which decides the threshold";
    case Algorithm::InnerBalls:
      return "balls inside of both cores, which decide the threshold";
    case Algorithm::BoxAxes:
      return "the fifteen axes of two boxes";
    case Algorithm::BoxPoints:
      return "the nearest points of two boxes";
    case Algorithm::RecalledFeatures:
      return "the nearest features of the last query";
    case Algorithm::Gjk:
      return "GJK";
    case Algorithm::GjkNewton:
      return "GJK, finished by Newton's method";
    case Algorithm::EnclosedBall:
      return "GJK: a ball inside of its last simplex decides the threshold";
    case Algorithm::SurfacePlane:
      return "GJK: the origin lies on the surface of the CSO, or the CSO has no volume";
    case Algorithm::Epa:
      return "EPA";
    case Algorithm::EpaNewton:
      return "EPA, finished by Newton's method";
    case Algorithm::EpaEllipsoid:
      return "EPA, finished by Newton's method and a solid inside of the CSO";
  }
  return "";
}

std::string statusText(Status status) {
  switch (status) {
    case Status::Unknown:
      return "unknown";
    case Status::Converged:
      return "converged";
    case Status::Threshold:
      return "threshold";
    case Status::IterationLimit:
      return "iteration limit";
    case Status::Degenerate:
      return "degenerate";
  }
  return "";
}

}  // namespace proximity_server::tools
