#pragma once

#include "node/robot/robot.h"
#include "proximity_server/Proximity.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/uncertainty/guaranteed_distances.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace proximity_server::node {

/// Appends why guaranteed distances are coarser than without limits, after `separator`; nothing if they are not.
void appendEnd(std::string& text, const char* separator, const scene::GuaranteedDistances& distances);

/// Returns the end of a text that appendEnd() has appended; "" if it appended nothing.
std::string endIn(const std::string& text);

/// After how many steps the time was over by such a text; nullopt if it was not.
std::optional<std::int64_t> stepsOfTimeOver(const std::string& text);

/// Writes the guaranteed distances of pairs into messages. Each caller needs an object of its own, because it is not
/// thread-safe. The robot must outlive it.
class Guarantees {
 public:
  /// With the uncertainty of the parameters, and without limits.
  explicit Guarantees(const Robot& robot) : Guarantees(robot, robot.uncertainty()) {}
  Guarantees(const Robot& robot, const scene::Uncertainty& uncertainty);

  void assume(const scene::Uncertainty& uncertainty) { distances_->assume(uncertainty); }
  void limit(const scene::GuaranteeLimits& limits) { distances_->limit(limits); }

  /// Sets the objects of the scene.
  void use(const std::shared_ptr<const scene::Objects>& objects);

  /// Sets the poses of the scene that answers, in the reference frame.
  void update(const scene::BodyPoses& poses, const scene::FramePoses& frames);
  void update(const scene::BodyPoses& poses, const scene::Scene& scene) { distances_->update(poses, scene); }

  /// Writes the guaranteed distance of a pair into its message; NaN if it is not known.
  void assign(Proximity& message, const scene::PairProximity& pair) { message.guaranteed = distances_->of(pair); }

  scene::GuaranteedDistances& distances() { return *distances_; }
  const scene::GuaranteedDistances& distances() const { return *distances_; }

 private:
  const Robot* robot_;
  GuaranteedPool::Lease distances_;
};

}  // namespace proximity_server::node
