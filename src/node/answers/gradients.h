#pragma once

#include "node/robot/robot.h"
#include "proximity_server/Proximity.h"
#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/model/kinematics.h"

#include <memory>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The position of a joint at these poses, [rad] in (-pi, pi] or [m]; NaN for planar and floating joints, and if a pose
/// is missing.
double jointPositionAt(const scene::RobotModel& robot, const scene::Joint& joint, const scene::BodyPoses& poses);

/// Writes the derivatives of a robot's distances into messages. Each caller needs an object of its own, because it is
/// not thread-safe. Messages that have held as many numbers before allocate no memory.
class Gradients {
 public:
  explicit Gradients(const Robot& robot);

  /// Sets the objects of the scene. `carriers` is the result of carriersOf().
  void use(std::shared_ptr<const scene::Objects> objects, scene::ObjectCarriers carriers);

  /// Sets the poses of the scene that answers, in the reference frame.
  void update(const scene::BodyPoses& poses) { derivatives_.update(poses); }

  /// The derivatives at these poses, with these objects.
  const scene::Derivatives& derivatives() const { return derivatives_; }

  /// The names of the columns of a gradient.
  const std::vector<std::string>& names() const { return names_; }

  /// Writes the gradient of a pair's distance into its message; it is empty if it is not known.
  void assign(Proximity& message, const scene::PairProximity& pair) const;

  /// Writes the position of each column at these poses, [rad] in (-pi, pi] or [m]. It is NaN if a pose is missing, and
  /// for planar and floating joints.
  void assignPositions(std::vector<double>& positions, const scene::BodyPoses& poses) const;

 private:
  std::shared_ptr<const scene::SceneModel> model_;
  scene::Derivatives derivatives_;
  std::vector<std::string> names_;
};

}  // namespace proximity_server::node
