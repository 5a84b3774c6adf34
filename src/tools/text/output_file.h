#pragma once

#include "system/whole_file.h"

#include <fstream>
#include <string>
#include <string_view>

namespace proximity_server::tools {

/// Throws std::invalid_argument naming the file if it cannot be written, so that this is known before hours of
/// computing. An existing file is not changed.
void requireWritable(const std::string& path);

/// Opens a file to be written. Throws std::invalid_argument with its name and the reason if that fails.
std::ofstream openOutput(const std::string& path);

/// Writes to the stream of a file. Throws std::invalid_argument with the name of the file and the reason if that fails.
void writeTo(std::ostream& stream, const std::string& name, std::string_view text);

/// Writes what the stream has not passed on yet. Fails as writeTo().
void flushTo(std::ostream& stream, const std::string& name);

/// Writes a file. Throws std::invalid_argument with its name and the reason if that fails.
void writeFile(const std::string& path, std::string_view text);

using system::because;

}  // namespace proximity_server::tools
