#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include "proximity_server/scene/object_files/file_value.h"

namespace proximity_server::node {

/// A parameter as a file would have it. What YAML cannot say, binary data and dates, becomes null.
scene::FileValue fileValueOf(XmlRpc::XmlRpcValue& parameter);

}  // namespace proximity_server::node
