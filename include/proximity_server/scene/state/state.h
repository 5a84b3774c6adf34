#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/scene_model/shape_ref.h"
#include "proximity_server/scene/state/degrees_of_freedom.h"
#include "proximity_server/scene/state/object_carriers.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace proximity_server::scene {

class PlacedRobot;
class Volumes;

/// The velocity field of a body relative to the body that carries it, at a unit velocity of one degree of freedom.
struct UnitTwist {
  Eigen::Vector3d linear;   ///< [m/s] per unit, at the origin
  Eigen::Vector3d angular;  ///< [rad/s] per unit
  Eigen::Vector3d origin;   ///< a point of the axis

  Eigen::Vector3d velocityAt(const Eigen::Vector3d& point) const { return linear + angular.cross(point - origin); }
};

/// The unit twists of one joint, in the order of its columns.
struct JointTwists {
  int count = 0;
  std::array<UnitTwist, 6> twists;
};

/// The places of a robot and its objects: one consistent set of poses. All poses are in one frame, and so are the
/// answers of Scene, Derivatives, FreeMotion and GuaranteedDistances about this state. The roots of the robots are at
/// rest, and so are objects that nothing carries.
///
/// Objects and poses are checked when they are set. If set() throws, nothing has changed. The places of volumes are
/// computed by the first question after set(), and kept. Therefore only one thread at a time may use a State, even a
/// const one. New poses allocate nothing; new objects do.
class State {
 public:
  /// Without objects and without poses. Throws std::invalid_argument without a model.
  explicit State(std::shared_ptr<const SceneModel> model);
  ~State();
  State(State&&) noexcept;
  State& operator=(State&&) noexcept;

  /// Returns a state of the same model and objects, without poses. The two share all data that never change.
  State forAnotherThread() const;

  const SceneModel& model() const { return *model_; }
  const RobotModel& robot() const { return model_->robot; }
  const std::shared_ptr<const SceneModel>& sharedModel() const { return model_; }

  /// Throws std::invalid_argument if this is a state of another robot.
  void requireModel(const SceneModel& model) const;

  /// Takes the next objects of the robot. All that no link holds are at rest like the roots. Those in frames that had
  /// no objects before have no pose until the next poses are set.
  /// Failure: throws std::invalid_argument without objects, and for objects of another model.
  void set(std::shared_ptr<const Objects> objects);

  /// Takes also the bodies that carry objects that no link holds.
  /// Failure: throws std::invalid_argument also if there is not one carrier for each frame, and for a carrier that is
  ///          not a body.
  void set(std::shared_ptr<const Objects> objects, ObjectCarriers carriers);

  /// Never nullptr.
  const std::shared_ptr<const Objects>& objects() const { return objects_; }

  /// Takes one pose for each body. Moving objects then have no pose.
  ///
  /// A pose that is not finite, or whose matrix is not a rotation within single precision, counts as missing.
  /// Failure: throws std::invalid_argument if there is not one pose for each body.
  void set(const BodyPoses& poses);

  /// Takes one pose for each body and one for each of Objects::frames().
  /// Failure: throws std::invalid_argument also if there is not one pose for each frame.
  void set(const BodyPoses& poses, const FramePoses& frames);

  const BodyPoses& poses() const { return poses_; }
  const FramePoses& frames() const { return frames_; }

  /// A number that changes whenever something is set. No other State has it.
  std::uint64_t revision() const { return revision_; }

  /// The pose of the frame in which the geometry of a link or an object is; nullopt if it is not known. That of a link,
  /// and of an object that a link holds, is the frame of its body. Throws std::invalid_argument for an object that does
  /// not exist.
  std::optional<Eigen::Isometry3d> poseOf(const ShapeRef& ref) const;

  /// The body that carries a link or an object; -1 for a point, and for an object that nothing carries. Throws std::invalid_argument for
  /// an object that does not exist.
  int bodyOf(const ShapeRef& ref) const;

  const DegreesOfFreedom& degreesOfFreedom() const { return *degrees_of_freedom_; }

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

  /// True if all poses are known that twistsOf() needs for the joint that carries a body.
  bool knowsJointOf(int body) const;

  /// The twists of the joint that carries a body. The pose of the body must be known.
  JointTwists twistsOf(int body) const;

  /// The twist of the joint that carries a body, if it has one position.
  UnitTwist twistOf(int body) const;

  /// [rad/s] The angular velocity of body b relative to body a at a velocity of the degrees of freedom. knowsBetween()
  /// must be true for the two.
  Eigen::Vector3d relativeTurn(int a, int b, const Eigen::Ref<const Eigen::VectorXd>& velocity) const;

  // For the questions:
  const PlacedRobot& placed() const;  ///< the volumes of all parts; valid as long as the State is not moved
  const std::shared_ptr<const Volumes>& volumes() const;

 private:
  State(std::shared_ptr<const SceneModel> model, std::shared_ptr<const DegreesOfFreedom> degrees_of_freedom,
        std::shared_ptr<const Volumes> volumes, std::shared_ptr<const Objects> objects, ObjectCarriers carriers);
  void take(const BodyPoses& poses);
  std::optional<Eigen::Isometry3d> poseOfFrame(const std::string& frame) const;

  std::shared_ptr<const SceneModel> model_;
  std::shared_ptr<const Objects> objects_;
  ObjectCarriers carriers_;
  std::shared_ptr<const DegreesOfFreedom> degrees_of_freedom_;
  BodyPoses poses_;
  FramePoses frames_;
  std::uint64_t revision_;
  std::unique_ptr<PlacedRobot> placed_;
  mutable std::uint64_t placed_revision_ = 0;  ///< of which `placed_` has the poses
};

}  // namespace proximity_server::scene
