#include "tools/program/options.h"

#include "tools/text/csv.h"

#include <algorithm>
#include <optional>
#include <thread>

namespace proximity_server::tools {
namespace {

constexpr int kMaxThreads = 1024;

}  // namespace

double readLength(const std::string& text, double least) {
  const std::optional<double> value = finiteNumber(text);
  if (!value || *value < least)
    throw std::invalid_argument("'" + text + "' is not a finite length of at least " + shortest(least) + " m");
  return *value;
}

long readCount(const std::string& text, long least, long most) {
  const std::optional<long> value = signedNumberIn<long>(text);
  if (!value || *value < least || *value > most)
    throw std::invalid_argument("'" + text + "' is not a whole number from " + std::to_string(least) + " to " +
                                std::to_string(most));
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
