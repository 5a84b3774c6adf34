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

}  // namespace proximity_server
