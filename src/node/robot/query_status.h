#pragma once

#include "proximity_server/QueryStatus.h"
#include "system/number_text.h"

#include <cstdint>
#include <string>
#include <utility>

namespace proximity_server {

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

namespace node {

/// A status with this code and the message as people can read it: names in it may come from a client.
inline QueryStatus statusOf(std::int8_t code, std::string message) {
  QueryStatus status;
  status.code = code;
  status.message = system::readable(std::move(message));
  return status;
}

}  // namespace node
}  // namespace proximity_server
