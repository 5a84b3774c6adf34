#include "proximity_server/scene/mesh/readable_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

namespace proximity_server::scene {

std::string whyUnreadable(const std::string& path) {
  const auto reason = [](int error) { return std::generic_category().message(error); };
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return reason(errno);
  if (S_ISDIR(status.st_mode)) return reason(EISDIR);
  return access(path.c_str(), R_OK) == 0 ? "" : reason(errno);
}

void requireReadable(const std::string& path) {
  const std::string why = whyUnreadable(path);
  if (!why.empty()) throw std::invalid_argument(path + ": cannot be read (" + why + ")");
}

}  // namespace proximity_server::scene
