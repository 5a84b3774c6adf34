#pragma once

#include "proximity_server/Clearance.h"
#include "proximity_server/QueryStatus.h"

namespace proximity_server {

/// The name of a Clearance::level as in Clearance.msg: "CLEAR". A value without a name counts as INVALID.
inline const char* levelName(Clearance::_level_type level) {
  switch (level) {
    case Clearance::CLEAR:
      return "CLEAR";
    case Clearance::WARN:
      return "WARN";
    case Clearance::STOP:
      return "STOP";
    case Clearance::COLLISION:
      return "COLLISION";
    default:
      return "INVALID";
  }
}

/// The name of the level to which Clearance::deciding_threshold belongs: of CLEAR it is that of WARN.
inline const char* levelOfThreshold(Clearance::_level_type level) {
  return levelName(level == Clearance::CLEAR ? Clearance::_level_type{Clearance::WARN} : level);
}

/// The name of a QueryStatus::code as in QueryStatus.msg: "TF_STALE". A value without a name counts as INTERNAL_ERROR.
inline const char* statusName(QueryStatus::_code_type code) {
  switch (code) {
    case QueryStatus::OK:
      return "OK";
    case QueryStatus::UNKNOWN_LINK:
      return "UNKNOWN_LINK";
    case QueryStatus::NO_COLLISION_GEOMETRY:
      return "NO_COLLISION_GEOMETRY";
    case QueryStatus::TF_UNAVAILABLE:
      return "TF_UNAVAILABLE";
    case QueryStatus::TF_STALE:
      return "TF_STALE";
    case QueryStatus::TF_EXTRAPOLATION:
      return "TF_EXTRAPOLATION";
    case QueryStatus::NOT_CONVERGED:
      return "NOT_CONVERGED";
    case QueryStatus::INVALID_ARGUMENT:
      return "INVALID_ARGUMENT";
    case QueryStatus::PAIR_EXCLUDED:
      return "PAIR_EXCLUDED";
    case QueryStatus::OVER_BUDGET:
      return "OVER_BUDGET";
    case QueryStatus::NO_VELOCITY:
      return "NO_VELOCITY";
    default:
      return "INTERNAL_ERROR";
  }
}

}  // namespace proximity_server
