#pragma once

#include "node/services/requests.h"
#include "proximity_server/QueryStatus.h"

namespace proximity_server::node {

/// Runs `ask`, which fills the response. An exception becomes the status of a response without numbers.
template <class Response, class Ask>
Response answered(const Response& empty, Ask ask) {
  Response response = empty;
  try {
    ask(response);
  } catch (const RequestError& error) {
    const auto header = response.header;
    response = empty;
    response.header = header;
    response.status = error.status();
  }
  response.success = response.status.code == QueryStatus::OK;
  return response;
}

}  // namespace proximity_server::node
