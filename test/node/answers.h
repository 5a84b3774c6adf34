#pragma once

#include <proximity_server/Proximity.h>
#include <proximity_server/QueryStatus.h>
#include <proximity_server/ShapeRef.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <set>
#include <string>

// Questions and answers of the services, for their tests.

namespace proximity_server::node {

constexpr double kTolerance = 1e-9;  // of the answers: the node's default

inline ShapeRef shape(const std::string& link, std::uint32_t index = 0, const std::string& name = "") {
  ShapeRef ref;
  ref.link = link;
  ref.index = index;
  ref.name = name;
  return ref;
}

/// A request of a service that takes two names.
template <class Request>
Request between(const std::string& a, const std::string& b, const ros::Time& stamp = {}) {
  Request request;
  request.a = shape(a);
  request.b = shape(b);
  request.stamp = stamp;
  return request;
}

template <class Vector>
void expectNear(const Vector& vector, double x, double y, double z, double tolerance = kTolerance) {
  EXPECT_NEAR(vector.x, x, tolerance);
  EXPECT_NEAR(vector.y, y, tolerance);
  EXPECT_NEAR(vector.z, z, tolerance);
}

template <class Vector>
bool isNaN(const Vector& vector) {
  return std::isnan(vector.x) && std::isnan(vector.y) && std::isnan(vector.z);
}

/// For pairs whose order the request leaves open.
inline std::set<std::string> links(const Proximity& pair) { return {pair.a.link, pair.b.link}; }

inline bool saysNothing(const Proximity& pair) {
  return pair.state == Proximity::UNKNOWN && !pair.points_valid && std::isnan(pair.distance) &&
         std::isnan(pair.lower_bound) && std::isnan(pair.upper_bound) && isNaN(pair.point_a) && isNaN(pair.point_b) &&
         isNaN(pair.normal) && isNaN(pair.point_a_link) && isNaN(pair.point_b_link);
}

/// `named` is a part of the message.
template <class Response>
void expectRefusal(const Response& response, int code, const std::string& named) {
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.status.code, code) << response.status.message;
  EXPECT_NE(response.status.message.find(named), std::string::npos) << response.status.message;
}

}  // namespace proximity_server::node
