#include "tools/command_line/number_options.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <thread>

#include "tools/command_line/csv.h"

namespace proximity_server::tools {
namespace {

constexpr int kMaxThreads = 1024;

/// Returns nullopt if the text is anything but one whole number.
std::optional<long> wholeNumber(const std::string& text) {
  const std::size_t plus = text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0;  // not for from_chars
  long value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + plus, end, value);
  return error == std::errc() && stop == end ? std::optional<long>(value) : std::nullopt;
}

}  // namespace

double readLength(const std::string& option, const std::string& text, double least) {
  const std::optional<double> value = finiteNumber(text);
  if (!value || *value < least) {
    throw CLI::ValidationError(option, "'" + text + "' is not a finite length of at least " + numberText(least) + " m");
  }
  return *value;
}

long readCount(const std::string& option, const std::string& text, long least, long most) {
  const std::optional<long> value = wholeNumber(text);
  if (!value || *value < least || *value > most) {
    throw CLI::ValidationError(
        option, "'" + text + "' is not a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  }
  return *value;
}

CLI::Option* addMeshTolerance(CLI::App& app, std::optional<double>& value) {
  return addLength(app, "--mesh-tolerance", value, 0.0,
                   "how far pieces may lie from their mesh (default: 0.005; 0: triangles)");
}

CLI::Option* addThreads(CLI::App& app, int& value) {
  value = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  return addCount(app, "--threads", value, 1, kMaxThreads, "default: all cores; the output is the same for any number");
}

}  // namespace proximity_server::tools
