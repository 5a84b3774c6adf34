#pragma once

#include "tools/pair_audit/pair_study.h"

#include <string>

namespace proximity_server::tools {

/// The pairs whose entries in the SRDF contradict the study, as indices into PairStudy::pairs.
struct SrdfFaults {
  std::vector<int> disabled_but_touch;    ///< dangerous: nobody would report their collisions; without neighbours
  std::vector<int> disabled_by_decision;  ///< they touch, too, but the SRDF says why, see scene::isDecision()
  std::vector<int> disabled_but_near;     ///< seen near, see PairEvidence::near, but never in contact
  std::vector<int> checked_but_never;     ///< see PairEvidence::isBeyond(): their checks are useless
  std::vector<int> checked_but_always;    ///< they raise an alarm in every state
};
SrdfFaults findSrdfFaults(const scene::SceneModel& model, const PairStudy& study);

/// True if the contact that was seen may be one of the convex pieces only, and not of the meshes.
bool isInDoubt(const scene::SceneModel& model, const PairEvidence& evidence);

enum class SrdfGiven : unsigned char { No, Yes };
/// The report as text: every pair under its class, then the errors of the SRDF, if there is one, entry by entry.
/// Lengths are in metres.
std::string auditReport(const scene::SceneModel& model, const PairStudy& study, SrdfGiven srdf);

}  // namespace proximity_server::tools
