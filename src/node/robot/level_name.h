#pragma once

#include "proximity_server/Clearance.h"

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

/// The name of the level to which Clearance::deciding_threshold belongs. For the level CLEAR this is WARN.
inline const char* levelOfThreshold(Clearance::_level_type level) {
  return levelName(level == Clearance::CLEAR ? Clearance::_level_type{Clearance::WARN} : level);
}

}  // namespace proximity_server
