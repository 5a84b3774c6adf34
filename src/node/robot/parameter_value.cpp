#include "node/robot/parameter_value.h"

#include <string>
#include <utility>

namespace proximity_server::node {

using scene::FileValue;
using XmlRpc::XmlRpcValue;

FileValue fileValueOf(XmlRpcValue& parameter) {
  switch (parameter.getType()) {
    case XmlRpcValue::TypeBoolean:
      return {static_cast<bool>(parameter)};
    case XmlRpcValue::TypeInt:
      return {static_cast<double>(static_cast<int>(parameter))};
    case XmlRpcValue::TypeDouble:
      return {static_cast<double>(parameter)};
    case XmlRpcValue::TypeString:
      return {static_cast<std::string>(parameter)};
    case XmlRpcValue::TypeArray: {
      FileValue::List entries;
      for (int i = 0; i < parameter.size(); ++i) entries.push_back(fileValueOf(parameter[i]));
      return {std::move(entries)};
    }
    case XmlRpcValue::TypeStruct: {
      FileValue::Map members;
      for (auto& [name, value] : parameter) members.push_back({name, fileValueOf(value)});
      return {std::move(members)};
    }
    default:
      return {};
  }
}

}  // namespace proximity_server::node
