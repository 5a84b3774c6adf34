#pragma once

#include <memory>
#include <string>
#include <vector>

#include "node/robot/robot.h"
#include "proximity_server/Proximity.h"
#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::node {

/// The derivatives of a robot's distances, as messages have them: the scratch of one caller. Not thread-safe. Nothing allocates
/// in messages that have held as much before.
class Gradients {
 public:
  explicit Gradients(const Robot& robot);

  /// Takes the objects of the scene; `carriers` are those of carriersOf().
  void use(std::shared_ptr<const scene::Objects> objects, scene::ObjectCarriers carriers);

  /// Takes the poses of the scene that answers, in the reference frame.
  void update(const scene::BodyPoses& poses) { derivatives_.update(poses); }

  /// The same poses and objects.
  const scene::Derivatives& derivatives() const { return derivatives_; }

  /// The names of the columns.
  const std::vector<std::string>& names() const { return names_; }

  /// Fills the gradient of a message about this pair; it is empty if it is not known.
  void assign(Proximity& message, const scene::PairProximity& pair) const;

  /// The position of each column [rad] in (-pi, pi] or [m] in these poses; NaN if a pose is missing, and for planar and
  /// floating joints.
  void assignPositions(std::vector<double>& positions, const scene::BodyPoses& poses) const;

 private:
  std::shared_ptr<const scene::SceneModel> model_;
  scene::Derivatives derivatives_;
  std::vector<std::string> names_;
};

}  // namespace proximity_server::node
