#pragma once

#include <string>

namespace proximity_server::node {

/// Replaces a file as a whole: the text is written into `path`.draft, which becomes the file when it is on the disk. Who reads the file,
/// even after a loss of power, finds all of the old text or all of the new one. Only one writer at a time.
/// Failure: throws std::system_error naming the file; then the file is as before.
void replaceFile(const std::string& path, const std::string& text);

}  // namespace proximity_server::node
