#pragma once

#include <ros/console.h>

#include <exception>
#include <string>

#include "node/services/requests.h"
#include "proximity_server/QueryStatus.h"

namespace proximity_server::node {

/// The status of an answer that failed because of a defect of this package. Logs the defect, so that it can be mended.
inline QueryStatus internalError(const std::string& what) {
  ROS_ERROR_STREAM("a request has no answer because of a defect of proximity_server: " << what);
  return statusOf(QueryStatus::INTERNAL_ERROR, "internal error: " + what);
}

/// Runs `ask`, which fills the response. An exception becomes the status of a response without numbers: a RequestError
/// has its own status, any other exception becomes INTERNAL_ERROR. Never throws.
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
