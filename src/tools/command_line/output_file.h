#pragma once

#include <string>

namespace proximity_server::tools {

/// Throws std::invalid_argument naming the file if it cannot be written, so that this is known before hours of
/// computing. An existing file is not changed.
void requireWritable(const std::string& path);

/// What errno says, behind a message: " (No space left on device)"; "" for 0.
std::string because(int cause);

}  // namespace proximity_server::tools
