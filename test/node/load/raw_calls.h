#pragma once

#include <ros/node_handle.h>
#include <ros/serialization.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

// Calls of services of any type, as bytes: nothing but ROS itself stands between a client and a server.

namespace proximity_server::node {

enum class Connection : unsigned char { Persistent, OnePerCall };

/// A request as it goes over the wire, its length in front.
using RawRequest = std::vector<std::uint8_t>;

template <class Request>
RawRequest rawRequest(const Request& request) {
  const ros::SerializedMessage bytes = ros::serialization::serializeMessage(request);
  return {bytes.buf.get(), bytes.buf.get() + bytes.num_bytes};
}

class RawClient {
 public:
  RawClient(std::string service, Connection connection);

  /// The response; nothing where ROS lost the call. The next call connects anew.
  std::optional<ros::SerializedMessage> call(const RawRequest& request);

 private:
  std::string service_;
  Connection connection_;
  ros::ServiceClient client_;
};

/// Whether our service had an answer: `success` is the first field of each.
bool isSuccess(const ros::SerializedMessage& response);

template <class Response>
Response fromRaw(ros::SerializedMessage bytes) {
  Response response;
  bytes.message_start = bytes.buf.get();
  ros::serialization::deserializeMessage(bytes, response);
  return response;
}

/// A service that does nothing but send an answer of a given size: the limit of what ROS allows.
ros::ServiceServer advertisePadding(ros::NodeHandle nh, const std::string& service);

/// A request of that service of as many bytes as `like` has, for an answer of so many. Both take at least four.
RawRequest paddingRequest(const RawRequest& like, std::size_t response_size);

}  // namespace proximity_server::node
