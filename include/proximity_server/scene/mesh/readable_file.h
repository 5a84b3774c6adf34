#pragma once

#include <string>

namespace proximity_server::scene {

/// Why a file cannot be read, in the words of the system: "No such file or directory", "Permission denied", "Is a directory";
/// "" if it can. A pipe is not opened, as its writer would notice.
std::string whyUnreadable(const std::string& path);

/// Throws std::invalid_argument with path and reason, "robot.urdf: cannot be read (No such file or directory)".
void requireReadable(const std::string& path);

}  // namespace proximity_server::scene
