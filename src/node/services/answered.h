#pragma once

#include <ros/console.h>

#include <exception>
#include <string>

#include "node/services/requests.h"
#include "proximity_server/QueryStatus.h"

namespace proximity_server::node {

/// The status of an answer that met a defect of this package, which is logged for those who can mend it.
inline QueryStatus internalError(const std::string& what) {
  QueryStatus status;
  status.code = QueryStatus::INTERNAL_ERROR;
  status.message = "internal error: " + what;
  ROS_ERROR_STREAM("a request has no answer because of a defect of proximity_server: " << what);
  return status;
}

/// Runs `ask`, which fills the response; what it throws becomes the status of a response without numbers: that of a
/// RequestError, and INTERNAL_ERROR for any other exception. Never throws.
template <class Response, class Ask>
Response answered(const Response& empty, Ask ask) {
  Response response = empty;
  const auto fail = [&](const QueryStatus& status) {
    const auto header = response.header;
    response = empty;
    response.header = header;
    response.status = status;
  };
  try {
    ask(response);
  } catch (const RequestError& error) {
    fail(error.status());
  } catch (const std::exception& error) {
    fail(internalError(error.what()));
  } catch (...) {
    fail(internalError("exception of unknown type"));
  }
  response.success = response.status.code == QueryStatus::OK;
  return response;
}

}  // namespace proximity_server::node
