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

/// What was found, for people: every pair under its class, then (where there is an SRDF) what is wrong with it, entry
/// by entry. Lengths in metres.
enum class SrdfGiven : unsigned char { No, Yes };
std::string auditReport(const scene::SceneModel& model, const PairStudy& study, SrdfGiven srdf);

}  // namespace proximity_server::tools
