#pragma once

#include "node/robot/robot.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The colour of each point [m] of a sensed source, as the field rgb of a PointCloud2: that of the level of the closest
/// link, or object that a link holds, that is checked against the source. `poses` are those of the bodies in the frame
/// of the points.
std::vector<std::uint32_t> coloursOf(const Robot& robot, const std::shared_ptr<const scene::Objects>& objects,
                                     const std::string& source, const scene::BodyPoses& poses,
                                     const std::vector<Eigen::Vector3d>& points);

}  // namespace proximity_server::node
