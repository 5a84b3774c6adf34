#pragma once

#include "node/gantry.h"

#include <dynamic_reconfigure/Reconfigure.h>

#include <string>

namespace proximity_server::node {

inline dynamic_reconfigure::ReconfigureRequest settingOf(const std::string& name, double value) {
  dynamic_reconfigure::ReconfigureRequest request;
  request.config.doubles.emplace_back().name = name;
  request.config.doubles.back().value = value;
  return request;
}
inline dynamic_reconfigure::ReconfigureRequest settingOf(const std::string& name, int value) {
  dynamic_reconfigure::ReconfigureRequest request;
  request.config.ints.emplace_back().name = name;
  request.config.ints.back().value = value;
  return request;
}
inline dynamic_reconfigure::ReconfigureRequest settingOf(const std::string& name, bool value) {
  dynamic_reconfigure::ReconfigureRequest request;
  request.config.bools.emplace_back().name = name;
  request.config.bools.back().value = value;
  return request;
}

/// Changes a live parameter of a node, whose name ends with a slash.
template <class Value>
void set(const std::string& node, const std::string& name, Value value) {
  call<dynamic_reconfigure::ReconfigureResponse>(node + "set_parameters", settingOf(name, value));
}

}  // namespace proximity_server::node
