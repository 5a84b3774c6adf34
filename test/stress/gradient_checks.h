#pragma once

#include "proximity_server/scene/derivative/derivatives.h"
#include "scene/derivative/posture.h"
#include "scene/posed_scene.h"

#include <Eigen/Geometry>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// A robot in a state, a pair, and a direction of its velocity.
struct GradientSample {
  Posture posture;
  ShapeRefPair pair;
};

/// A source of samples.
struct GradientFamily {
  std::string name;
  std::shared_ptr<const SceneModel> model;
  std::shared_ptr<const Objects> objects;  ///< nullptr: none; none of them moves with a frame
  std::function<GradientSample(PosedScene& scene, Chance& chance)> draw;
  bool is_pair_of_solids = false;  ///< "a" and "b" of the objects are single shapes
};

/// Every pair of two kinds of shapes, as objects "a" and "b" of a robot with joints of every type between them.
std::vector<GradientFamily> pairsOfShapes();

/// The demo robot, two of them in one model, and the one with objects; the example robots to test where they are found,
/// and the same two of Panda.
std::vector<GradientFamily> demoRobots();
std::vector<GradientFamily> exampleRobots();

/// The signed distance of a pair while the robot moves with one velocity.
class DistanceAlong {
 public:
  DistanceAlong(PosedScene& scene, const DegreesOfFreedom& columns, const GradientSample& sample,
                const Eigen::VectorXd& velocity)
      : scene_(scene), columns_(columns), sample_(sample), velocity_(velocity) {}

  /// As exactly as it can be computed.
  PairProximity after(double time) const;

  BodyPoses posesAfter(double time) const { return sample_.posture.moved(columns_, velocity_, time).poses(); }

 private:
  PosedScene& scene_;
  const DegreesOfFreedom& columns_;
  const GradientSample& sample_;
  const Eigen::VectorXd& velocity_;
};

/// A derivative by differences of the distance, and how far it is off at most because distances are.
struct Difference {
  double value;
  double error;
};

/// The two-sided derivative at time 0, extrapolated (Richardson) from three steps of time. Returns nullopt where the
/// distance is not seen to be smooth around it: with each size of step, the extrapolations from two and from three
/// steps differ, or that from a tenth of the size does; or an answer is not unique, or other <collision>s are the
/// closest.
std::optional<Difference> centralDifference(const DistanceAlong& distance);

/// The derivative at time 0 to the future side, extrapolated from four steps; nullopt where the distance is not smooth
/// right after.
std::optional<Difference> forwardDifference(const DistanceAlong& distance);

/// The result of a sample.
struct GradientObservation {
  enum class Kind : unsigned char {
    Unmoved,     ///< nothing moves one against the other
    NotUnique,   ///< the answer says so
    Kink,        ///< see centralDifference()
    Unresolved,  ///< the differences are not exact enough
    Judged
  };
  Kind kind;
  double distance = 0.0;
  double error = 0.0;    ///< of gradient . velocity, relative to the speed of the witness points against each other
  double allowed = 0.0;  ///< error of the differences themselves
};

constexpr double kGradientError = 1e-7;

/// An observer of one family. The seed of a sample says all.
class GradientObserver {
 public:
  /// `tolerance` [m] is that of the question whose answer gets a gradient.
  explicit GradientObserver(const GradientFamily& family, double tolerance = Question().tolerance);

  GradientObservation observe(unsigned seed);

  /// Returns the error that the same formula has, for the last observation that was Judged, with other points and
  /// another normal. They are in the frame of the first body.
  double errorWith(const Eigen::Vector3d& point_a, const Eigen::Vector3d& point_b, const Eigen::Vector3d& normal);

  const PairProximity& lastPair() const { return pair_; }
  const BodyPoses& lastPoses() const { return poses_; }

 private:
  Eigen::VectorXd scaledVelocity(const GradientSample& sample, const Eigen::VectorXd& velocity) const;
  Eigen::Vector3d shiftOf(const ShapeRef& ref, const Eigen::Vector3d& point, const BodyPoses& before,
                          const BodyPoses& after) const;

  const GradientFamily& family_;
  Question question_;
  PosedScene scene_, exact_scene_;
  PairProximity pair_;
  BodyPoses poses_;
  Eigen::VectorXd velocity_, row_;
  double reference_ = 0.0;
};

}  // namespace proximity_server::scene
