#pragma once

#include "node/services/requests.h"
#include "proximity_server/QueryStatus.h"

#include <ros/console.h>

#include <exception>
#include <string>

namespace proximity_server::node {

/// The status of an answer that failed because of a defect of this package. Logs the defect, so that users can report
/// it.
inline QueryStatus internalError(const std::string& what) {
  const QueryStatus status = statusOf(QueryStatus::INTERNAL_ERROR, "internal error: " + what);
  ROS_ERROR_STREAM("a request has no answer because of a defect of proximity_server: " << status.message);
  return status;
}

/// Returns a response that `ask` fills. If `ask` throws, the response is `empty`, with the status of a RequestError, or
/// with INTERNAL_ERROR for any other exception. Never throws.
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
