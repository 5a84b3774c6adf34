#pragma once

#include <string>

namespace proximity_server::tools {

/// Throws std::invalid_argument naming the file where it cannot be written; to be asked before hours of computing. What
/// there is stays as it is.
void requireWritable(const std::string& path);

}  // namespace proximity_server::tools
