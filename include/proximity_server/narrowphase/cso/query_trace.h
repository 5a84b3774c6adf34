#pragma once

#include "proximity_server/narrowphase/cso/cso.h"

#include <array>
#include <vector>

namespace proximity_server::narrowphase {

/// The algorithm of signedDistance() that an answer comes from.
enum class Algorithm : unsigned char {
  None,               ///< the pose is not finite, or lengths add up to more than 1e30 m
  PointsAndSegments,  ///< closed form of points and segments, and of a point and a box
  ParallelAxes,       ///< closed form of solids of revolution about parallel axes
  FirstDirection,     ///< the first vertex of the CSO decided the threshold, before GJK
  InnerBalls,         ///< overlap: balls inside of both cores decided the threshold, before GJK
  BoxAxes,            ///< the fifteen axes of two boxes: they overlap, or an axis decided the threshold
  BoxPoints,          ///< the nearest points of two boxes apart
  RecalledFeatures,   ///< the features of two polytopes at which the last query ended are the nearest ones again
  Gjk,
  GjkNewton,     ///< GJK, finished by Newton's method
  EnclosedBall,  ///< overlap: a ball inside of GJK's last simplex decided the threshold, without EPA
  SurfacePlane,  ///< overlap: the origin lies on the surface of the CSO, or the CSO has no volume
  Epa,
  EpaNewton,     ///< EPA, with a direction found by Newton's method
  EpaEllipsoid,  ///< the same, and an ellipsoid inside of the CSO, the profiles of solids of revolution with nearly
                 ///< parallel axes, or a search about these axes prove the depth at least as well as the closest face
};

/// The steps of a query.
/// Frame: the frame of a; metres.
/// If a hull that is far from the origin of its frame was moved to it (Shape::nearOrigin()),
///        the points are relative to its first vertex; points of the CSO are unchanged.
/// Cores: all points and bounds are about the cores. The signed distance of the shapes is less than the distance of the
///        cores by the sum of the margins.
/// Steps: if a query was made again, without its threshold or with hulls moved, the steps of the last search.
struct QueryTrace {
  /// One iteration of GJK: w is found, the bounds are compared, and w is added to the simplex.
  struct GjkStep {
    Eigen::Vector3d normal;  ///< unit; w is the vertex of the CSO farthest along it
    CsoVertex w;
    double lower_bound;  ///< [m] of the distance, by the support plane at w
    double upper_bound;  ///< [m] by the nearest point; infinity before there is one
    /// The simplex with w, without the vertices that the nearest point does not need. If w brings no progress, the
    /// simplex of the step before.
    std::vector<CsoVertex> simplex;
    Eigen::Vector3d nearest;  ///< point of this simplex nearest to the origin; NaN if the simplex is empty
    bool has_progress;        ///< false: the search ended at w, and the simplex is from the step before
  };

  /// One iteration of EPA: the closest face is found, and the vertex of the CSO beyond it.
  struct EpaStep {
    std::vector<std::array<int, 3>> faces;  ///< of the polytope before w is added, by indices into `polytope`,
                                            ///< counter-clockwise from outside
    std::array<int, 3> closest;             ///< the face whose normal is tested
    Eigen::Vector3d normal;                 ///< unit, outward
    CsoVertex w;                            ///< the vertex of the CSO farthest along it
    double lower_bound;                     ///< [m] of the depth, by the closest face
    double depth;                           ///< [m] the smallest depth known after this step: an upper bound
  };

  Algorithm algorithm = Algorithm::None;
  std::vector<GjkStep> gjk;
  std::vector<EpaStep> epa;
  std::vector<CsoVertex> polytope;              ///< the vertices that EPA found, in their order
  std::vector<std::array<int, 3>> final_faces;  ///< of the polytope with which EPA ended
};

}  // namespace proximity_server::narrowphase
