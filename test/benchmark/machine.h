#pragma once

#include <nlohmann/json.hpp>

#include <ctime>
#include <fstream>
#include <string>

namespace proximity_server::benchmark {

/// Returns processor, date (UTC) and compiler, which readers of a result need to know.
inline nlohmann::json machine() {
  std::string processor = "unknown";
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) processor = line.substr(line.find(':') + 2);
  const std::time_t now = std::time(nullptr);
  char date[16];
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
  return {{"processor", processor}, {"date", date}, {"compiler", "g++ " __VERSION__}};
}

}  // namespace proximity_server::benchmark
