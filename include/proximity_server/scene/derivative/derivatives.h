#pragma once

#include <Eigen/Core>
#include <memory>

#include "proximity_server/scene/derivative/degrees_of_freedom.h"
#include "proximity_server/scene/derivative/object_carriers.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

class ContactFeatures;
class PlacedJoints;

/// The derivatives of the distances of one robot by its degrees of freedom, in one set of poses: the scratch of one
/// caller. Not thread-safe. Nothing allocates after the first update.
///
/// It takes the same poses as the Scene that gave the answers. The roots of the robots rest, and so do objects that nothing
/// carries.
class Derivatives {
 public:
  /// Throws std::invalid_argument without a model.
  explicit Derivatives(std::shared_ptr<const SceneModel> model);
  ~Derivatives();
  Derivatives(Derivatives&&) noexcept;
  Derivatives& operator=(Derivatives&&) noexcept;

  const DegreesOfFreedom& degreesOfFreedom() const;

  /// Takes the objects of the scene. All that no link holds rest where the roots do.
  /// Throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// The same with objects that bodies of the robot carry in other ways.
  /// Throws std::invalid_argument also if there is not one carrier for each frame, and for one that is no body.
  void use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers);

  /// Throws std::invalid_argument if there is not one pose for each body. Moving objects have no pose then: gradient() does not
  /// need it, rate() does.
  void update(const BodyPoses& poses);

  /// The same with one pose for each of Objects::frames(), as Scene takes them.
  /// Throws std::invalid_argument also if there is not one pose for each frame.
  void update(const BodyPoses& poses, const FramePoses& frames);

  /// The derivative of a pair's signed distance by each degree of freedom.
  ///
  /// Units:   [m/rad] and [m/m], one entry for each of degreesOfFreedom(); 0 for joints that are not between the two.
  /// Sign:    positive where the distance grows; in overlap, where the depth shrinks.
  /// Formula: n . (v_b - v_a), where v is the velocity of each body at its own point. As the distance is the smallest one of
  ///          two points, how these two move on the surfaces does not count (Danskin, The Theory of Max-Min, with
  ///          Applications, 1966).
  /// Error:   that of the normal and the points, and the rounding of the poses. The normal of two convex pieces that are apart
  ///          is off by no more than acos(lower_bound / upper_bound) [rad]; test/README.md tells what random states showed.
  ///          Where PairProximity::result.unique is false the distance has a kink: this is the derivative for one choice of
  ///          points, rate() has that of a direction. The same is so where two pairs of pieces are equally close, which is not
  ///          noticed.
  /// Failure: returns false, with NaN, if the pair is Unknown or has no points, or if a pose between the two is missing.
  ///          Throws std::invalid_argument for another size of `gradient`, and for an object that does not exist.
  bool gradient(const PairProximity& pair, Eigen::Ref<Eigen::VectorXd> gradient) const;

  /// How fast a pair's signed distance changes at a velocity, to the future side: where the distance has a kink it is its
  /// one-sided derivative.
  ///
  /// Units:   [m/s] for a velocity in [rad/s] and [m/s], one entry for each of degreesOfFreedom().
  /// Sign:    as that of gradient().
  /// Formula: gradient() . velocity where the result is unique; otherwise the smallest of n . (v_b - v_a) over all pairs of
  ///          witness points of the contact feature, as where two faces are parallel (Danskin, as above; in overlap the depth
  ///          is the height of a face of the CSO, whose concave envelope moves as the highest of these pairs does).
  /// Error:   that of gradient(). On the safe side, never too large, are: faces and edges that are parallel within the
  ///          tolerance, as points are taken into account that are as far as the accepted gap of the bounds; and pairs
  ///          whose normal is one of several (concentric shapes, equally short ways out of an overlap), as the distance
  ///          is the largest one of these ways. Pieces of the two that meet in the same plane are part of the feature where the
  ///          result is not unique; other pieces that are equally close, as two balls over a floor, are not noticed.
  /// Failure: NaN where gradient() fails, and for a moving object whose pose is not known if the result is not unique. Throws
  ///          std::invalid_argument for another size of `velocity`, and for an object that does not exist.
  double rate(const PairProximity& pair, const Eigen::Ref<const Eigen::VectorXd>& velocity);

 private:
  void requireSize(Eigen::Index size) const;

  std::unique_ptr<ContactFeatures> features_;
  std::unique_ptr<PlacedJoints> joints_;
  FramePoses frames_;    ///< of moving objects
  Eigen::VectorXd row_;  ///< scratch
};

}  // namespace proximity_server::scene
