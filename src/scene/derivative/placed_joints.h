#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/degrees_of_freedom.h"
#include "proximity_server/scene/state/object_carriers.h"

#include <Eigen/Geometry>

#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// The motion of a body and all that it carries for one unit of a degree of freedom, if no other joint moves.
struct UnitTwist {
  Eigen::Vector3d linear;   ///< [m] of `origin`, per unit
  Eigen::Vector3d angular;  ///< [rad] per unit
  Eigen::Vector3d origin;   ///< a point of the axis

  Eigen::Vector3d velocityAt(const Eigen::Vector3d& point) const { return linear + angular.cross(point - origin); }
};

/// The unit twists of one joint, in the order of its columns.
struct JointTwists {
  int count = 0;
  std::array<UnitTwist, 6> twists;
};

/// The joints of a robot in one set of poses, for the derivatives of its distances. The poses and the twists are in one
/// frame. After the first update nothing is allocated.
class PlacedJoints {
 public:
  explicit PlacedJoints(std::shared_ptr<const SceneModel> model);

  const SceneModel& model() const { return *model_; }
  const RobotModel& robot() const { return model_->robot; }
  const DegreesOfFreedom& degreesOfFreedom() const { return degrees_of_freedom_; }

  /// All objects that no link holds are at rest like the roots.
  /// Throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// Throws std::invalid_argument also if there is not one carrier for each frame, and for a carrier that is not a
  /// body.
  void use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers);
  const Objects* objects() const { return objects_.get(); }

  /// Moving objects then have no pose. Throws std::invalid_argument if there is not one pose for each body.
  void update(const BodyPoses& poses);

  /// Throws std::invalid_argument also if there is not one pose for each of Objects::frames().
  void update(const BodyPoses& poses, const FramePoses& frames);

  /// The same of poses that the scene was given last: those that it uses are not checked again. The scene has the same
  /// objects.
  void update(const BodyPoses& poses, const Scene& scene);

  const BodyPoses& poses() const { return poses_; }

  /// The pose of the frame in which the geometry of a link or an object is, see PlacedObject; nullopt if it is not
  /// known.
  std::optional<Eigen::Isometry3d> poseOf(const ShapeRef& ref) const;

  /// The body that carries a link or an object. -1 for an object that nothing carries: it is taken to be at rest like
  /// the roots of the robots.
  int bodyOf(const ShapeRef& ref) const;

  enum class Side : unsigned char { A, B };  ///< tells which of the two bodies a joint carries

  /// Calls `visit(joint's body, side)` for each body with a joint between two bodies. The body -1 is the place where
  /// the roots rest.
  template <class Visit>
  void forEachBetween(int a, int b, const Visit& visit) const {
    while (a != b) {
      int& later = a > b ? a : b;  // parents come first
      if (robot().bodies[later].joint >= 0) visit(later, a > b ? Side::A : Side::B);
      later = robot().bodies[later].parent;
    }
  }

  /// True if all poses are known that twistsOf() needs for the joints between two bodies.
  bool knowsBetween(int a, int b) const;

  /// The same for the joint that carries a body.
  bool knowsJointOf(int body) const;

  /// The twists of the joint that carries a body. The pose of the body must be known.
  JointTwists twistsOf(int body) const;

  /// The same of a joint with one position.
  UnitTwist twistOf(int body) const;

  /// [rad/s] The angular velocity of body b relative to body a at a velocity of the degrees of freedom. knowsBetween()
  /// must be true for the two.
  Eigen::Vector3d relativeTurn(int a, int b, const Eigen::Ref<const Eigen::VectorXd>& velocity) const;

 private:
  void requireCountOf(const BodyPoses& poses) const;

  std::shared_ptr<const SceneModel> model_;
  std::shared_ptr<const Objects> objects_;
  ObjectCarriers carriers_;
  DegreesOfFreedom degrees_of_freedom_;
  BodyPoses poses_;
  FramePoses frames_;
};

}  // namespace proximity_server::scene
