#include "tools/text/output_file.h"

#include <cerrno>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

/// Throws if writing to the stream has failed, with the cause that errno tells.
void requireWritten(const std::ostream& stream, const std::string& name) {
  const int cause = errno;
  if (!stream) throw std::invalid_argument(name + ": writing failed" + because(cause));
}

}  // namespace

void writeTo(std::ostream& stream, const std::string& name, std::string_view text) {
  errno = 0;
  requireWritten(stream << text, name);
}

void flushTo(std::ostream& stream, const std::string& name) {
  errno = 0;
  requireWritten(stream << std::flush, name);
}

}  // namespace proximity_server::tools
