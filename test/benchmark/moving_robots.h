#pragma once

#include <nlohmann/json.hpp>
#include <regex>
#include <vector>

#include "peers/robots.h"

namespace proximity_server::benchmark {

using namespace peers;

/// Time of contact (contact distance 0 and 2 cm) and smallest distance of each robot along random joint motions of one
/// second: ours, samples at 1 kHz, and what samples at the guarantee of ours would take. A motion begins in a state
/// without contact; what is timed begins with the joint positions. One entry a row whose name matches and a way to ask.
nlohmann::json measureMovingRobots(const std::vector<NamedRobot>& robots, int motions, const std::regex& wanted);

}  // namespace proximity_server::benchmark
