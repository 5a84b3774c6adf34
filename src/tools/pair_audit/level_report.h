#pragma once

#include "proximity_server/scene/levels/always_near.h"
#include "tools/pair_audit/level_shares.h"
#include "tools/pair_audit/pair_study.h"

#include <string>

namespace proximity_server::tools {

/// The pairs that set COLLISION and STOP most often: ten, and all suspects, see PairLevels::isSuspect(). Each has the line
/// that ends it, of an SRDF or of the node's parameters, and what this line costs. A high share of COLLISION without a
/// suspect is explained. `usual` are the thresholds of pairs without their own.
std::string levelReport(const scene::RobotModel& robot, const PairStudy& study, const LevelShares& shares,
                        const scene::StopAndWarn& usual);

/// The likely reason of the contacts of a suspect: "an overlap of the model".
std::string suspicionOf(const PairLevels& pair);

/// The states in which nothing warns of a pair once it is disabled, as a text.
std::string costOfDisabling(const PairLevels& pair, const PairStudy& study);

}  // namespace proximity_server::tools
