#pragma once

#include <Eigen/Core>
#include <memory>

#include "proximity_server/scene/derivative/degrees_of_freedom.h"
#include "proximity_server/scene/derivative/object_carriers.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"

namespace proximity_server::scene {

class PlacedJoints;

/// The derivatives of the distances of one robot by its degrees of freedom, in one set of poses: the scratch of one
/// caller. Not thread-safe. Nothing allocates after the first update.
///
/// It takes the same poses as the Scene that gave the answers. The roots of the robots rest, and so do objects that nothing
/// carries.
class Derivatives {
 public:
  explicit Derivatives(std::shared_ptr<const SceneModel> model);
  ~Derivatives();
  Derivatives(Derivatives&&) noexcept;
  Derivatives& operator=(Derivatives&&) noexcept;

  const DegreesOfFreedom& degreesOfFreedom() const;

  /// Takes the objects of the scene. All that no link holds rest where the roots do.
  void use(std::shared_ptr<const Objects> objects);

  /// The same with objects that bodies of the robot carry in other ways.
  /// Throws std::invalid_argument if there is not one carrier for each frame, and for one that is no body.
  void use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers);

  /// Throws std::invalid_argument if there is not one pose for each body.
  void update(const BodyPoses& poses);

  /// The derivative of a pair's signed distance by each degree of freedom.
  ///
  /// Units:   [m/rad] and [m/m], one entry for each of degreesOfFreedom(); 0 for joints that are not between the two.
  /// Sign:    positive where the distance grows; in overlap, where the depth shrinks.
  /// Formula: n . (v_b - v_a), where v is the velocity of each body at its own point. As the distance is the smallest one of
  ///          two points, how these two move on the surfaces does not count (Danskin, The Theory of Max-Min, with
  ///          Applications, 1966).
  /// Error:   that of the normal and the points, and the rounding of the poses. Where PairProximity::result.unique is false the
  ///          distance has a kink: this is the derivative for one choice of points, rate() has that of a direction. The same
  ///          is so where two pairs of pieces are equally close, which is not noticed.
  /// Failure: returns false, with NaN, if the pair is Unknown or has no points, or if a pose between the two is missing.
  ///          Throws std::invalid_argument for another size of `gradient`, and for an object that does not exist.
  bool gradient(const PairProximity& pair, Eigen::Ref<Eigen::VectorXd> gradient) const;

 private:
  std::unique_ptr<PlacedJoints> joints_;
};

}  // namespace proximity_server::scene
