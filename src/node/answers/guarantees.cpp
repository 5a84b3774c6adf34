#include "node/answers/guarantees.h"

#include "node/objects/object_needs.h"

namespace proximity_server::node {

Guarantees::Guarantees(const Robot& robot, const scene::Uncertainty& uncertainty)
    : robot_(&robot), distances_(robot.borrowGuaranteed()) {
  distances_->assume(uncertainty);
}

void Guarantees::use(const std::shared_ptr<const scene::Objects>& objects) {
  distances_->use(objects, carriersBesideRoots(*robot_, *objects));
}

void Guarantees::update(const scene::BodyPoses& poses, const scene::FramePoses& frames) {
  if (frames.empty())
    distances_->update(poses);
  else
    distances_->update(poses, frames);
}

}  // namespace proximity_server::node
