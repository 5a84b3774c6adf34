#pragma once

#include "benchmark/wanted.h"
#include "peers/robots.h"

#include <nlohmann/json.hpp>

#include <vector>

namespace proximity_server::benchmark {

using namespace peers;

/// Measures time of contact (contact distance 0 and 2 cm) and smallest distance of each robot along random joint
/// motions of one second, along splines of ten, and within tubes about these: ours, samples at 1 kHz of the motion, and
/// what samples at the guarantee of ours would take. A motion begins in a state without contact; the time begins with
/// the joint positions. Returns an entry for each wanted row and way
/// to ask.
nlohmann::json measureMovingRobots(const std::vector<NamedRobot>& robots, int motions, const Wanted& wanted);

}  // namespace proximity_server::benchmark
