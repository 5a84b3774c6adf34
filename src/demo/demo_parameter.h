#pragma once

#include <ros/node_handle.h>

#include <stdexcept>
#include <string>

namespace proximity_server::demo {

/// The value of a parameter. Throws std::invalid_argument naming a parameter that is missing or has another type.
template <typename Value>
Value parameter(const ros::NodeHandle& nh, const std::string& name) {
  Value value;
  if (!nh.getParam(name, value)) throw std::invalid_argument("the parameter " + nh.resolveName(name) + " is missing");
  return value;
}

}  // namespace proximity_server::demo
