#pragma once

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/proof/joint_box.h"

#include <nlohmann/json.hpp>

#include <string>

namespace proximity_server::tools {

enum class ProofFormat : unsigned char { Text, Json };

/// The intervals of a box by the names of their joints.
inline nlohmann::ordered_json boxJson(const scene::JointBox& box, const scene::RobotModel& robot) {
  auto object = nlohmann::ordered_json::object();
  for (const scene::JointRange& interval : box)
    object[robot.joints[interval.joint].name] = {interval.lower, interval.upper};
  return object;
}

/// A report; bytes of names that are not UTF-8 are replaced.
inline std::string jsonText(const nlohmann::ordered_json& report) {
  return report.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace proximity_server::tools
