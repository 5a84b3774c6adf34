#include "tools/explain/explanation.h"

#include "proximity_server/narrowphase/signed_distance.h"

namespace proximity_server::tools {

using narrowphase::Rung;
using narrowphase::Status;

Explanation explain(const ExplainedPair& pair, const narrowphase::Options& options,
                    const Eigen::Vector3d& first_direction) {
  narrowphase::WarmStart start;
  start.axis = first_direction;
  Explanation explanation{pair, {}, {}};
  explanation.answer = signedDistance(pair.a.shape, pair.b.shape, pair.a_T_b, options, start, explanation.trace);
  return explanation;
}

std::string rungText(Rung rung) {
  switch (rung) {
    case Rung::None:
      return "nothing: the pose is not finite, or lengths add up to more than 1e50 m";
    case Rung::PointsAndSegments:
      return "the closed form of points and segments, and of a point and a box";
    case Rung::InnerBalls:
      return "balls inside of both cores, which decide the threshold";
    case Rung::ParallelAxes:
      return "the closed form of solids of revolution about parallel axes";
    case Rung::BoxAxes:
      return "the fifteen axes of two boxes";
    case Rung::FirstDirection:
      return "the first vertex of the CSO, which decides the threshold";
    case Rung::Gjk:
      return "GJK";
    case Rung::GjkNewton:
      return "GJK, finished by Newton's method";
    case Rung::EnclosedBall:
      return "GJK: a ball inside of its last simplex decides the threshold";
    case Rung::SurfacePlane:
      return "GJK: the origin lies on the surface of the CSO, or the CSO has no volume";
    case Rung::Epa:
      return "EPA";
    case Rung::EpaNewton:
      return "EPA, finished by Newton's method";
    case Rung::EpaEllipsoid:
      return "EPA, finished by Newton's method and an ellipsoid inside of the CSO";
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
