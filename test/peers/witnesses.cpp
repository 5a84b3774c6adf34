#include "peers/witnesses.h"

#include "peers/aborts.h"

#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

namespace proximity_server::peers {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

template <fcl::GJKSolverType kSolver>
std::optional<Witnesses> fclContact(const Solid& a, const Solid& b, const Isometry3d& a_T_b) {
  fcl::CollisionRequestd request;
  request.enable_contact = true;
  request.gjk_solver_type = kSolver;
  fcl::CollisionResultd result;
  if (fcl::collide(a.fcl.get(), fcl::Transform3d::Identity(), b.fcl.get(), a_T_b, request, result) == 0)
    return std::nullopt;
  // Its point is in the middle of the overlap.
  const fcl::Contactd& contact = result.getContact(0);
  const Vector3d half = 0.5 * contact.penetration_depth * contact.normal;
  return Witnesses{contact.pos + half, contact.pos - half, contact.normal};
}

template <fcl::GJKSolverType kSolver>
std::optional<Witnesses> askFcl(const Solid& a, const Solid& b, const Isometry3d& a_T_b, bool are_apart) {
  if (!are_apart) return fclContact<kSolver>(a, b, a_T_b);
  fcl::DistanceRequestd request;
  request.enable_nearest_points = true;
  request.gjk_solver_type = kSolver;
  fcl::DistanceResultd result;
  if (fcl::distance(a.fcl.get(), fcl::Transform3d::Identity(), b.fcl.get(), a_T_b, request, result) <= 0.0)
    return std::nullopt;
  const Vector3d between = result.nearest_points[1] - result.nearest_points[0];
  if (between.norm() == 0.0) return std::nullopt;
  return Witnesses{result.nearest_points[0], result.nearest_points[1], between.normalized()};
}

template <fcl::GJKSolverType kSolver>
std::optional<Witnesses> askFclGuarded(const Solid& a, const Solid& b, const Isometry3d& a_T_b, bool are_apart) {
  return answerOf([&] { return askFcl<kSolver>(a, b, a_T_b, are_apart); }).value_or(std::nullopt);
}

Vector3d fromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

std::optional<Witnesses> askBullet(const Solid& a, const Solid& b, const Isometry3d& a_T_b, bool) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver epa;
  btGjkPairDetector detector(a.bullet.get(), b.bullet.get(), &simplex, &epa);
  btGjkPairDetector::ClosestPointInput input;
  const Eigen::Matrix<btScalar, 4, 4> matrix = a_T_b.matrix().cast<btScalar>();
  input.m_transformA.setIdentity();
  input.m_transformB.setFromOpenGLMatrix(matrix.data());
  btPointCollector result;
  detector.getClosestPoints(input, result, nullptr);
  if (!result.m_hasResult) return std::nullopt;
  const Vector3d towards_a = fromBullet(result.m_normalOnBInWorld), on_b = fromBullet(result.m_pointInWorld);
  return Witnesses{on_b + static_cast<double>(result.m_distance) * towards_a, on_b, -towards_a};
}

}  // namespace

std::vector<WitnessLibrary> witnessLibraries() {
  return {{"FCL libccd", askFclGuarded<fcl::GST_LIBCCD>},
          {"FCL INDEP", askFclGuarded<fcl::GST_INDEP>},
          {"Bullet GJK", askBullet}};
}

}  // namespace proximity_server::peers
