#include "peers/libraries.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <ccd/ccd.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

namespace proximity_server::peers {

using namespace narrowphase;
namespace {

bool everything(Question, bool) { return true; }

Answer askOurs(const SolidPair& pair, Question question, double tolerance, WarmStart& warm) {
  Options options = question == Question::Boolean ? Options::above(0.0) : Options{};
  if (tolerance != kDefaultTolerance) options.distance_tolerance = tolerance;
  const SignedDistance result = signedDistance(pair.a->ours, pair.b->ours, pair.a_T_b, options, warm);
  if (question == Question::Boolean) return {result.lower_bound > 0.0 ? 1.0 : -1.0, result.iterations};
  return {result.distance, result.iterations};
}

Options aboveFiveCentimetres() { return Options::above(0.05); }
Options aboveZero() { return Options::above(0.0); }
Options everythingAsked() { return {}; }

template <Options (*kAsked)()>
Answer askOursFor(const SolidPair& pair, Question, double, WarmStart& warm) {
  const SignedDistance result = signedDistance(pair.a->ours, pair.b->ours, pair.a_T_b, kAsked(), warm);
  return {result.distance, result.iterations};
}

template <fcl::GJKSolverType kSolver>
std::size_t collideFcl(const SolidPair& pair, bool contacts, double tolerance, fcl::CollisionResultd& result) {
  fcl::CollisionRequestd request;
  request.enable_contact = contacts;
  request.gjk_solver_type = kSolver;
  if (tolerance != kDefaultTolerance) request.gjk_tolerance = tolerance;
  return fcl::collide(pair.a->fcl.get(), fcl::Transform3d::Identity(), pair.b->fcl.get(), pair.a_T_b, request, result);
}

template <fcl::GJKSolverType kSolver>
Answer askFcl(const SolidPair& pair, Question question, double tolerance, WarmStart&) {
  const bool apart = pair.placement == Placement::Apart;
  if (question == Question::Boolean) {
    fcl::CollisionResultd result;
    return {collideFcl<kSolver>(pair, false, tolerance, result) > 0 ? -1.0 : 1.0};
  }
  if (!apart && kSolver == fcl::GST_INDEP) {  // its distance() asserts where this solver finds no contact
    fcl::CollisionResultd result;
    if (collideFcl<kSolver>(pair, true, tolerance, result) == 0) return {};
    return {-result.getContact(0).penetration_depth};
  }
  // Asked for the depth, FCL leaves its closed forms; so it is asked where there is one only.
  fcl::DistanceRequestd request;
  request.enable_nearest_points = true;
  request.enable_signed_distance = !apart;
  request.gjk_solver_type = kSolver;
  if (tolerance != kDefaultTolerance) request.distance_tolerance = tolerance;
  fcl::DistanceResultd result;
  const auto origin = fcl::Transform3d::Identity();
  return {fcl::distance(pair.a->fcl.get(), origin, pair.b->fcl.get(), pair.a_T_b, request, result)};
}

/// A solid as libccd wants it: a support function.
struct CcdSolid {
  const Shape& shape;
  Eigen::Isometry3d pose;
  int vertex = 0;

  static void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
    auto& self = *static_cast<CcdSolid*>(const_cast<void*>(object));
    const Eigen::Vector3d d = self.pose.linear().transpose() * Eigen::Map<const Eigen::Vector3d>(direction->v);
    const Eigen::Vector3d on_core = supportPoint(self.shape, d, self.vertex);
    Eigen::Map<Eigen::Vector3d>(point->v) = self.pose * (on_core + self.shape.margin() * d.normalized());
  }
  static void centre(const void* object, ccd_vec3_t* point) {
    const auto& self = *static_cast<const CcdSolid*>(object);
    Eigen::Map<Eigen::Vector3d>(point->v) = self.pose * self.shape.centre();
  }
};

bool ccdAnswers(Question question, bool overlap) { return question == Question::Boolean || overlap; }

Answer askCcd(const SolidPair& pair, Question question, double tolerance, WarmStart&) {
  CcdSolid a{pair.a->ours, Eigen::Isometry3d::Identity()}, b{pair.b->ours, pair.a_T_b};
  ccd_t request;
  CCD_INIT(&request);
  request.support1 = request.support2 = CcdSolid::support;
  request.center1 = request.center2 = CcdSolid::centre;
  request.max_iterations = 500;
  request.epa_tolerance = tolerance != kDefaultTolerance ? tolerance : 1e-6;  // its own default is 1e-4, FCL's 1e-6
  if (question == Question::Boolean) return {ccdGJKIntersect(&a, &b, &request) != 0 ? -1.0 : 1.0};
  ccd_real_t depth;
  ccd_vec3_t direction, position;
  if (ccdGJKPenetration(&a, &b, &request, &depth, &direction, &position) != 0) return {};
  return {-depth};
}

btTransform toBullet(const Eigen::Isometry3d& pose) {
  const Eigen::Matrix<btScalar, 4, 4> matrix = pose.matrix().cast<btScalar>();
  btTransform transform;
  transform.setFromOpenGLMatrix(matrix.data());
  return transform;
}

Answer askBulletDetector(const SolidPair& pair, Question, double, WarmStart&) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver epa;
  btGjkPairDetector detector(pair.a->bullet.get(), pair.b->bullet.get(), &simplex, &epa);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA.setIdentity();
  input.m_transformB = toBullet(pair.a_T_b);
  btPointCollector result;
  detector.getClosestPoints(input, result, nullptr);
  return {static_cast<double>(result.m_distance)};
}

Answer askBulletEpa2(const SolidPair& pair, Question question, double, WarmStart&) {
  const btTransform origin = btTransform::getIdentity(), pose = toBullet(pair.a_T_b);
  const btVector3 guess = pose.getOrigin();
  btGjkEpaSolver2::sResults result;
  if (btGjkEpaSolver2::Distance(pair.a->bullet.get(), origin, pair.b->bullet.get(), pose, guess, result))
    return {static_cast<double>(result.distance)};
  if (question == Question::Boolean) return {-1.0};
  if (!btGjkEpaSolver2::Penetration(pair.a->bullet.get(), origin, pair.b->bullet.get(), pose, guess, result)) return {};
  return {static_cast<double>(result.distance)};
}

}  // namespace

std::vector<Library> allLibraries() {
  return {{"ours", true, everything, askOurs},
          {"FCL libccd", true, everything, askFcl<fcl::GST_LIBCCD>},
          {"FCL INDEP", true, everything, askFcl<fcl::GST_INDEP>},
          {"libccd", true, ccdAnswers, askCcd},
          {"Bullet GJK", false, everything, askBulletDetector},
          {"Bullet EPA2", false, everything, askBulletEpa2}};
}

std::vector<Library> oursAskedLess() {
  return {{"distance or depth", false, everything, askOursFor<everythingAsked>},
          {"no depth", false, everything, askOursFor<Options::apart>},
          {"above 5 cm?", false, everything, askOursFor<aboveFiveCentimetres>},
          {"apart?", false, everything, askOursFor<aboveZero>}};
}

}  // namespace proximity_server::peers
