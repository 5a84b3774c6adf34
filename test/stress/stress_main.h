#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "benchmark/machine.h"
#include "stress/progress_bar.h"

namespace proximity_server::narrowphase {

/// One failure: its name, and the line of the file that the tests replay.
struct RecordedLine {
  std::string name, json;
};

/// The failing cells of a summary, each with the seed that makes it again.
template <class Summary>
std::vector<RecordedLine> linesOfCells(const Summary& summary, unsigned seed) {
  std::vector<RecordedLine> lines;
  for (const auto& failure : summary.failures) {
    const nlohmann::json line = {
        {"name", failure.sentence}, {"family", summary.name}, {"seed", seed}, {"number", failure.number}};
    lines.push_back({summary.name + ", cell " + std::to_string(failure.number) + ": " + failure.sentence, line.dump()});
  }
  return lines;
}

/// Appends each failure as a line, and prints its name.
inline void record(const std::vector<RecordedLine>& lines, const std::string& path) {
  std::ofstream file(path, std::ios::app);
  for (const RecordedLine& line : lines) {
    std::printf("%s\n", line.name.c_str());
    file << line.json << "\n";
  }
  if (!file) throw std::runtime_error("cannot write " + path);
}

inline void write(const nlohmann::json& result, const std::string& path) {
  std::ofstream file(path);
  if (!(file << result.dump(1) << "\n")) throw std::runtime_error("cannot write " + path);
}

/// The run with its progress, its table, and its files.
///
/// `Tool` says what differs:
///   Run, Summary                         what is asked, and what one family showed
///   kName, kAbout, kUnit, kRecordFile    the program, its help, "pairs" or "motions", a file below test/data
///   static std::int64_t& count(Run&)     how many of all families together
///   static void addOptions(CLI::App&, Run&)
///   static std::vector<Summary> runAll(const Run&, std::atomic<std::int64_t>& done)
///   static void print(const std::vector<Summary>&)
///   static nlohmann::json toJson(const Summary&)
///   static std::vector<RecordedLine> lines(const Summary&, unsigned seed)
/// Failure: throws std::runtime_error if a file cannot be written.
template <typename Tool>
int runTool(typename Tool::Run& asked, const std::string& record_path, const std::string& json_path) {
  std::atomic<std::int64_t> done{0};
  const auto start = std::chrono::steady_clock::now();
  std::vector<typename Tool::Summary> summaries;
  {
    const ProgressBar bar(done, Tool::count(asked));
    summaries = Tool::runAll(asked, done);
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  Tool::print(summaries);
  std::int64_t failed = 0;
  nlohmann::json result = benchmark::machine();
  result.update(
      {{Tool::kUnit, done.load()}, {"seed", asked.seed}, {"threads", asked.threads}, {"seconds", seconds.count()}});
  for (const auto& summary : summaries) {
    failed += summary.failed;
    result["families"].push_back(Tool::toJson(summary));
    if (!summary.failures.empty()) record(Tool::lines(summary, asked.seed), record_path);
  }
  if (!json_path.empty()) write(result, json_path);
  std::printf("%lld %s, seed %u: %lld failures in %.0f s on %u threads\n", static_cast<long long>(done), Tool::kUnit,
              asked.seed, static_cast<long long>(failed), seconds.count(), asked.threads);
  return failed == 0 ? 0 : 1;
}

/// main(): 0 without a failure, 1 with failures, 2 where it could not be run.
template <typename Tool>
int stressMain(int argc, char** argv) {
  typename Tool::Run asked;
  asked.threads = std::max(1u, std::thread::hardware_concurrency());
  std::string json_path, record_path = std::string(PROXIMITY_SOURCE_DIR) + "/test/data/" + Tool::kRecordFile;

  CLI::App app(Tool::kAbout, Tool::kName);
  Tool::addOptions(app, asked);
  app.add_option("--seed", asked.seed, std::string("the same seed gives the same ") + Tool::kUnit)
      ->capture_default_str();
  app.add_option("--family", asked.family, "one family only, by its name in the table");
  app.add_option("--threads", asked.threads, "default: one for each core")->check(CLI::PositiveNumber);
  app.add_option("--json", json_path, "where the table goes as JSON, for ./dev plot");
  app.add_option("--record", record_path, std::string("where failing ") + Tool::kUnit + " go, one line each");
  CLI11_PARSE(app, argc, argv);
  try {
    return runTool<Tool>(asked, record_path, json_path);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", Tool::kName, error.what());
    return 2;
  }
}

}  // namespace proximity_server::narrowphase
