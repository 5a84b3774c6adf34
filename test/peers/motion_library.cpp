#include "peers/motion_library.h"

#include "peers/swept_bisection.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/continuous_collision.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>
#include <fcl/narrowphase/detail/traversal/distance/shape_conservative_advancement_traversal_node.h>

#include <stdexcept>

namespace proximity_server::peers {

using namespace narrowphase;
namespace {

constexpr int kMaxSteps = 1000000;  // of FCL's advancement with a small error of the time

ContactAnswer answerFrom(const TimeOfContact& result) {
  const bool decided = result.contact || result.status == Status::Converged;
  return {result.contact, decided, result.t_free, result.t_contact, result.queries};
}

/// FCL's motions remember the time of the last question, at which continuousCollide would begin.
void rewind(const MovingSolidPair& pair) {
  pair.a.fcl->integrate(0.0);
  pair.b.fcl->integrate(0.0);
}

ContactAnswer collideFcl(const MovingSolidPair& pair, const fcl::ContinuousCollisionRequestd& request,
                         double sample_step) {
  rewind(pair);
  fcl::ContinuousCollisionResultd result;
  fcl::continuousCollide(pair.a.solid->fcl.get(), pair.a.fcl.get(), pair.b.solid->fcl.get(), pair.b.fcl.get(), request,
                         result);
  if (!result.is_collide) return {};
  return {true, true, std::max(0.0, result.time_of_contact - sample_step), result.time_of_contact, 0};
}

template <typename FclShape>
class FclAdvancement {
 public:
  using Solver = fcl::detail::GJKSolver_libccd<double>;
  using Node = fcl::detail::ShapeConservativeAdvancementTraversalNode<FclShape, FclShape, Solver>;

  explicit FclAdvancement(const MovingSolidPair& pair)
      : a_(static_cast<const FclShape*>(pair.a.solid->fcl.get())),
        b_(static_cast<const FclShape*>(pair.b.solid->fcl.get())) {
    node_.motion1 = pair.a.fcl.get();
    node_.motion2 = pair.b.fcl.get();
    rewind(pair);
  }

  ContactAnswer run(double time_error) {
    takePoses();
    fcl::detail::initialize(node_, *a_, node_.tf1, *b_, node_.tf2, &solver_);
    fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    if (fcl::collide(a_, node_.tf1, b_, node_.tf2, request, result) > 0) return {true, true, 0.0, 0.0, 1};
    for (int step = 1; step <= kMaxSteps; ++step) {
      node_.delta_t = 1.0;
      node_.leafTesting(0, 0);
      if (node_.delta_t <= time_error) return {true, true, node_.toc, node_.toc, step};
      node_.toc += node_.delta_t;
      if (node_.toc > 1.0) return {false, true, 1.0, std::numeric_limits<double>::quiet_NaN(), step};
      node_.motion1->integrate(node_.toc);
      node_.motion2->integrate(node_.toc);
      takePoses();
    }
    throw std::runtime_error("FCL's advancement does not end");
  }

 private:
  void takePoses() {
    node_.motion1->getCurrentTransform(node_.tf1);
    node_.motion2->getCurrentTransform(node_.tf2);
  }

  const FclShape* a_;
  const FclShape* b_;
  Solver solver_;
  Node node_;
};

ContactAnswer advanceFcl(const MovingSolidPair& pair, double time_error) {
  const fcl::NODE_TYPE type = pair.a.solid->fcl->getNodeType();
  if (pair.b.solid->fcl->getNodeType() != type) throw std::invalid_argument("both solids must be of one kind");
  switch (type) {
    case fcl::GEOM_BOX:
      return FclAdvancement<fcl::Boxd>(pair).run(time_error);
    case fcl::GEOM_CAPSULE:
      return FclAdvancement<fcl::Capsuled>(pair).run(time_error);
    case fcl::GEOM_CYLINDER:
      return FclAdvancement<fcl::Cylinderd>(pair).run(time_error);
    case fcl::GEOM_CONVEX:
      return FclAdvancement<fcl::Convexd>(pair).run(time_error);
    default:
      throw std::invalid_argument("boxes, capsules, cylinders and hulls only");
  }
}

ContactAnswer sampleContact(const MovingSolidPair& pair, int samples) {
  const double step = 1.0 / (samples - 1);
  WarmStart warm;
  for (int i = 0; i < samples; ++i) {
    const double time = i * step;
    const SignedDistance result =
        signedDistance(pair.a.solid->ours, pair.b.solid->ours, pair.poseOfBInA(time), Options::above(0.0), warm);
    if (result.lower_bound <= 0.0) return {true, true, std::max(0.0, time - step), time, i + 1};
  }
  return {false, true, 1.0, std::numeric_limits<double>::quiet_NaN(), samples};
}

MinimumAnswer sampleMinimum(const MovingSolidPair& pair, int samples) {
  const double step = 1.0 / (samples - 1);
  WarmStart warm;
  MinimumAnswer answer;
  answer.distance = std::numeric_limits<double>::infinity();
  answer.queries = samples;
  for (int i = 0; i < samples; ++i) {
    const SignedDistance result =
        signedDistance(pair.a.solid->ours, pair.b.solid->ours, pair.poseOfBInA(i * step), {}, warm);
    answer.distance = std::min(answer.distance, result.distance);
  }
  return answer;
}

MinimumAnswer minimumWithin(const MovingSolidPair& pair, double tolerance) {
  MinimumOptions options;
  options.tolerance = tolerance;
  const MinimumOverMotion result =
      minimumDistance(pair.a.solid->ours, pair.a.ours, pair.b.solid->ours, pair.b.ours, options);
  return {result.lower_bound, result.upper_bound, result.queries};
}

}  // namespace

ContactLibrary oursWithin(double tolerance) {
  ContactOptions options;
  options.tolerance = tolerance;
  return {"ours", tolerance, [options](const MovingSolidPair& pair) {
            return answerFrom(timeOfContact(pair.a.solid->ours, pair.a.ours, pair.b.solid->ours, pair.b.ours, options));
          }};
}

ContactLibrary sweptBisectionWithin(double tolerance) {
  ContactOptions options;
  options.tolerance = tolerance;
  return {"swept bisection", tolerance, [options](const MovingSolidPair& pair) {
            return answerFrom(
                timeOfContactBySweeping(pair.a.solid->ours, pair.a.ours, pair.b.solid->ours, pair.b.ours, options));
          }};
}

ContactLibrary fclAdvancement(fcl::GJKSolverType solver) {
  fcl::ContinuousCollisionRequestd request;
  request.gjk_solver_type = solver;
  request.ccd_solver_type = fcl::CCDC_CONSERVATIVE_ADVANCEMENT;
  const char* name = solver == fcl::GST_LIBCCD ? "FCL advancement" : "FCL advancement, INDEP";
  return {name, 1e-4, [request](const MovingSolidPair& pair) { return collideFcl(pair, request, 0.0); }};
}

ContactLibrary fclAdvancementWithin(double time_error) {
  return {"FCL advancement", time_error,
          [time_error](const MovingSolidPair& pair) { return advanceFcl(pair, time_error); }};
}

ContactLibrary fclNaive(int samples) {
  fcl::ContinuousCollisionRequestd request;
  request.ccd_solver_type = fcl::CCDC_NAIVE;
  request.num_max_iterations = static_cast<std::size_t>(samples);
  request.toc_err = 0.5 / samples;  // of the two the one that asks for fewer samples counts
  const double step = 1.0 / (samples - 1);
  return {"FCL naive", static_cast<double>(samples),
          [request, step](const MovingSolidPair& pair) { return collideFcl(pair, request, step); }};
}

ContactLibrary samplingBy(int samples) {
  return {"sampling", static_cast<double>(samples),
          [samples](const MovingSolidPair& pair) { return sampleContact(pair, samples); }};
}

std::vector<ContactLibrary> contactLibraries() {
  return {oursWithin(1e-9),
          sweptBisectionWithin(1e-9),
          fclAdvancement(fcl::GST_LIBCCD),
          fclAdvancement(fcl::GST_INDEP),
          fclNaive(10),
          fclNaive(1000),
          samplingBy(1000)};
}

std::vector<ContactLibrary> tunedContactLibraries() {
  std::vector<ContactLibrary> libraries;
  for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
    libraries.push_back(oursWithin(tolerance));
    libraries.push_back(sweptBisectionWithin(tolerance));
  }
  for (const double time_error : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8})
    libraries.push_back(fclAdvancementWithin(time_error));
  for (const int samples : {10, 100, 1000, 10000}) {
    libraries.push_back(fclNaive(samples));
    libraries.push_back(samplingBy(samples));
  }
  return libraries;
}

std::vector<MinimumLibrary> minimumLibraries() {
  std::vector<MinimumLibrary> libraries;
  for (const double tolerance : {1e-9, 1e-6, 1e-3})
    libraries.push_back(
        {"ours", tolerance, [tolerance](const MovingSolidPair& pair) { return minimumWithin(pair, tolerance); }});
  for (const int samples : {30, 100, 1000, 10000})
    libraries.push_back({"sampling", static_cast<double>(samples),
                         [samples](const MovingSolidPair& pair) { return sampleMinimum(pair, samples); }});
  return libraries;
}

}  // namespace proximity_server::peers
