#pragma once

#include "system/whole_file.h"

#include <ostream>
#include <string>
#include <string_view>

namespace proximity_server::tools {

/// Writes to a stream. Throws std::invalid_argument with its name and the reason if that fails. Files are written by
/// system::WholeFile alone.
void writeTo(std::ostream& stream, const std::string& name, std::string_view text);

/// Writes what the stream has not passed on yet. Fails as writeTo().
void flushTo(std::ostream& stream, const std::string& name);

using system::because;

}  // namespace proximity_server::tools
