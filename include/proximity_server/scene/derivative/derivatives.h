#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/degrees_of_freedom.h"
#include "proximity_server/scene/state/object_carriers.h"

#include <Eigen/Core>

#include <memory>

namespace proximity_server::scene {

class ContactFeatures;
class PlacedJoints;

/// The derivatives of the distances of one robot by its degrees of freedom, in one set of poses, and the working memory
/// of one caller. Not thread-safe. After the first update nothing is allocated.
///
/// It takes the same poses as the Scene that gave the answers. The roots of the robots are at rest, and so are objects
/// that nothing carries.
class Derivatives {
 public:
  /// Throws std::invalid_argument without a model.
  explicit Derivatives(std::shared_ptr<const SceneModel> model);
  ~Derivatives();
  Derivatives(Derivatives&&) noexcept;
  Derivatives& operator=(Derivatives&&) noexcept;

  const DegreesOfFreedom& degreesOfFreedom() const;

  /// Takes the objects of the scene. All objects that no link holds are at rest like the roots.
  /// Throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// Takes the objects of the scene, and the bodies of the robot that carry objects that no link holds.
  /// Throws std::invalid_argument also if there is not one carrier for each frame, and for a carrier that is not a
  /// body.
  void use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers);

  /// Throws std::invalid_argument if there is not one pose for each body. Moving objects then have no pose; gradient()
  /// does not need it, but rate() does.
  void update(const BodyPoses& poses);

  /// Takes also one pose for each of Objects::frames(), as Scene does.
  /// Throws std::invalid_argument also if there is not one pose for each frame.
  void update(const BodyPoses& poses, const FramePoses& frames);

  /// The derivative of a pair's signed distance by each degree of freedom.
  ///
  /// Units:   [m/rad] and [m/m], one entry for each of degreesOfFreedom(); 0 for joints that are not between the two.
  /// Sign:    positive if the distance grows, or if the depth of an overlap shrinks.
  /// Formula: n . (v_b - v_a), where v is the velocity of each body at its own witness point. The distance is the
  ///          smallest one of two points, so it does not matter how these two move on the surfaces (Danskin, The Theory
  ///          of Max-Min, with Applications, 1966).
  /// Error:   that of the normal and the points, and the rounding of the poses. The normal of two convex pieces that
  ///          are apart is off by no more than acos(lower_bound / upper_bound) [rad]; test/README.md has results for
  ///          random states. If PairProximity::result.unique is false, the distance has a kink, and this is the
  ///          derivative for one choice of points; rate() computes that of a direction. If two pairs of pieces are
  ///          equally close, the distance has a kink, too, but this is not detected.
  /// Failure: returns false, with NaN, if the pair is Unknown or has no points, or if a pose between the two is
  ///          missing.
  ///          Throws std::invalid_argument for a wrong size of `gradient`, and for an object that does not exist.
  bool gradient(const PairProximity& pair, Eigen::Ref<Eigen::VectorXd> gradient) const;

  /// The rate of change of a pair's signed distance at a velocity, towards the future: if the distance has a kink, this
  /// is its one-sided derivative.
  ///
  /// Units:   [m/s] for a velocity in [rad/s] and [m/s], one entry for each of degreesOfFreedom().
  /// Sign:    as for gradient().
  /// Formula: gradient() . velocity if the result is unique. Otherwise the smallest value of n . (v_b - v_a) over all
  ///          pairs of witness points of the contact feature, for example of two parallel faces (Danskin, as above; in
  ///          overlap the depth is the height of a face of the CSO, whose concave envelope moves like the highest of
  ///          these pairs).
  /// Error:   that of gradient(). In two cases the result is on the safe side, never too large. First, if faces or
  ///          edges are parallel within the tolerance: points count that are as far as the accepted gap of the bounds.
  ///          Second, if the normal is one of several (concentric shapes, equally short ways out of an overlap): the
  ///          distance is the largest one of these ways. If the result is not unique, pieces of the two that meet in
  ///          the same plane are part of the feature. Other pieces that are equally close, such as two balls over a
  ///          floor, are not detected.
  /// Failure: NaN if gradient() fails, or if the result is not unique and the pose of a moving object is not known.
  ///          Throws std::invalid_argument for a wrong size of `velocity`, and for an object that does not exist.
  double rate(const PairProximity& pair, const Eigen::Ref<const Eigen::VectorXd>& velocity);

 private:
  void requireSize(Eigen::Index size) const;

  std::unique_ptr<ContactFeatures> features_;
  std::unique_ptr<PlacedJoints> joints_;
  FramePoses frames_;    ///< of moving objects
  Eigen::VectorXd row_;  ///< working memory
};

}  // namespace proximity_server::scene
