#include "node/load/raw_calls.h"

#include <ros/service_client_options.h>
#include <boost/make_shared.hpp>

#include <algorithm>
#include <cstring>
#include <utility>

namespace proximity_server::node {
namespace {

constexpr char kAnyType[] = "*";
constexpr std::size_t kLengthBytes = 4;

class Padding : public ros::ServiceCallbackHelper {
 public:
  bool call(ros::ServiceCallbackHelperCallParams& params) override {
    std::uint32_t size = 0;
    if (params.request.num_bytes < sizeof size) return false;
    std::memcpy(&size, params.request.buf.get(), sizeof size);
    // Before the answer goes a byte that says that there is one, and its length.
    params.response.num_bytes = 1 + kLengthBytes + size;
    params.response.buf.reset(new std::uint8_t[params.response.num_bytes]);
    std::memset(params.response.buf.get(), 1, params.response.num_bytes);
    std::memcpy(params.response.buf.get() + 1, &size, sizeof size);
    return true;
  }
};

}  // namespace

RawClient::RawClient(std::string service, Connection connection)
    : service_(std::move(service)), connection_(connection) {}

std::optional<ros::SerializedMessage> RawClient::call(const RawRequest& request) {
  if (!client_.isValid()) {
    ros::ServiceClientOptions options(service_, kAnyType, connection_ == Connection::Persistent, ros::M_string());
    client_ = ros::NodeHandle().serviceClient(options);
  }
  boost::shared_array<std::uint8_t> bytes(new std::uint8_t[request.size()]);
  std::copy(request.begin(), request.end(), bytes.get());
  ros::SerializedMessage response;
  if (!client_.call(ros::SerializedMessage(bytes, request.size()), response, kAnyType)) return std::nullopt;
  return response;
}

bool isSuccess(const ros::SerializedMessage& response) { return response.num_bytes > 0 && response.buf[0] == 1; }

ros::ServiceServer advertisePadding(ros::NodeHandle nh, const std::string& service) {
  ros::AdvertiseServiceOptions options;
  options.service = service;
  options.md5sum = options.datatype = options.req_datatype = options.res_datatype = kAnyType;
  options.helper = boost::make_shared<Padding>();
  return nh.advertiseService(options);
}

RawRequest paddingRequest(const RawRequest& like, std::size_t response_size) {
  const auto size = static_cast<std::uint32_t>(response_size);
  RawRequest request(std::max(like.size(), kLengthBytes + sizeof size));
  const auto body = static_cast<std::uint32_t>(request.size() - kLengthBytes);
  std::memcpy(request.data(), &body, sizeof body);
  std::memcpy(request.data() + kLengthBytes, &size, sizeof size);
  return request;
}

}  // namespace proximity_server::node
