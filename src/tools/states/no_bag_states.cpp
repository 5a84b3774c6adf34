// This stands for bag_states.cpp where the package is built without rosbag.
#include "tools/states/bag_states.h"

#include <stdexcept>

namespace proximity_server::tools {

std::unique_ptr<StateSource> openBag(const BagOptions& options, const scene::RobotModel&) {
  throw std::invalid_argument(options.file + ": this build reads no bags, as it was made without rosbag");
}

}  // namespace proximity_server::tools
