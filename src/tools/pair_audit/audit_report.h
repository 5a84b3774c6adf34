#pragma once

#include <string>

#include "tools/pair_audit/pair_study.h"

namespace proximity_server::tools {

/// Entries of an SRDF that contradict the study, as indices into PairStudy::pairs.
struct SrdfFaults {
  std::vector<int> disabled_but_touch;  ///< dangerous: collisions that nobody would report; without neighbours
  std::vector<int> checked_but_never;   ///< useless work
  std::vector<int> checked_but_always;  ///< an alarm in every state
};
SrdfFaults findSrdfFaults(const scene::SceneModel& model, const PairStudy& study);

/// The state as `joint=position` for the joints that move the pair; the others do not matter.
std::string stateText(const scene::RobotModel& robot, const scene::ShapeRefPair& pair,
                      const scene::Positions& positions);

/// The report as text: every pair under its class, then the errors of the SRDF, if there is one, entry
/// by entry. Lengths in metres.
enum class SrdfGiven : unsigned char { No, Yes };
std::string auditReport(const scene::SceneModel& model, const PairStudy& study, SrdfGiven srdf);

}  // namespace proximity_server::tools
