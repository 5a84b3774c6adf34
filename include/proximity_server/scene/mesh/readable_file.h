#pragma once

#include <string>

namespace proximity_server::scene {

/// The reason why a file cannot be read, in the words of the system: "No such file or directory", "Permission denied",
/// "Is a directory"; "" if it can be read. A pipe is not opened, because its writer would notice that.
std::string whyUnreadable(const std::string& path);

/// Throws std::invalid_argument with path and reason, "robot.urdf: cannot be read (No such file or directory)".
void requireReadable(const std::string& path);

}  // namespace proximity_server::scene
