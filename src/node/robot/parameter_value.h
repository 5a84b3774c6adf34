#pragma once

#include "proximity_server/scene/files/file_value.h"

#include <xmlrpcpp/XmlRpcValue.h>

namespace proximity_server::node {

/// Converts a parameter into the value that a file of the same text would have. Binary data and dates, which YAML does
/// not have, become null.
scene::FileValue fileValueOf(XmlRpc::XmlRpcValue& parameter);

}  // namespace proximity_server::node
