#include "benchmark/machine.h"
#include "stress/campaign.h"
#include "tools/program/options.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <thread>

namespace proximity_server::stress {
namespace {

/// Shows on a terminal how much of the work is done.
class ProgressBar {
 public:
  ProgressBar(const std::atomic<std::int64_t>& done, std::int64_t total) : done_(done), total_(total) {
    if (isatty(STDERR_FILENO)) thread_ = std::thread([this] { draw(); });
  }
  ~ProgressBar() {
    ended_ = true;
    if (thread_.joinable()) thread_.join();
  }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

 private:
  void draw() const {
    constexpr int kWidth = 50;
    while (!ended_) {
      const double part = std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
      std::fprintf(stderr, "\r[%-*.*s] %5.1f %%", kWidth, static_cast<int>(kWidth * part),
                   "##################################################", 100.0 * part);
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    std::fprintf(stderr, "\r%*s\r", kWidth + 12, "");
  }

  const std::atomic<std::int64_t>& done_;
  std::int64_t total_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

/// Counts stay integers.
nlohmann::json toJson(double number) {
  if (number == std::round(number) && std::abs(number) < 1e15) return static_cast<std::int64_t>(number);
  return number;
}

nlohmann::json toJson(const Tally& tally) {
  nlohmann::json result{{"family", tally.family}};
  for (const auto& [name, number] : tally.numbers()) result[name] = toJson(number);
  return result;
}

/// Appends each failure as a line, and prints its name.
void record(const Campaign& campaign, const Tally& tally, unsigned seed, const std::string& path) {
  std::ofstream file(path, std::ios::app);
  for (const Failure& failure : tally.failures()) {
    const std::string name = tally.family + ", seed " + std::to_string(seed) + ", " + campaign.one + " " +
                             std::to_string(failure.number) + ": " + failure.sentence;
    const nlohmann::json by_seed{{"name", name}, {"family", tally.family}, {"seed", seed}, {"number", failure.number}};
    std::printf("%s\n", name.c_str());
    file << (failure.line ? failure.line(name) : by_seed.dump()) << "\n";
  }
  if (!file) throw std::runtime_error("cannot write " + path);
}

int runAndReport(const Campaign& campaign, const Run& run, const std::string& record_path,
                 const std::string& json_path) {
  std::atomic<std::int64_t> done{0};
  const Stopwatch watch;
  std::vector<Tally> tallies;
  {
    const ProgressBar bar(done, run.cases);
    tallies = observe(campaign, run, done);
  }
  const double seconds = watch.seconds();
  printHead("family", campaign.name_width, campaign.columns);
  nlohmann::json result = benchmark::machine();
  result.update({{campaign.cases, done.load()}, {"seed", run.seed}, {"threads", run.threads}, {"seconds", seconds}});
  std::int64_t failed = 0;
  for (const Tally& tally : tallies) {
    printRow(campaign.name_width, campaign.columns, tally);
    failed += tally.failed();
    result["families"].push_back(toJson(tally));
  }
  std::printf("%s\n", campaign.legend);
  for (const Tally& tally : tallies)
    if (tally.failed() > 0) record(campaign, tally, run.seed, record_path);
  if (!json_path.empty()) {
    std::ofstream file(json_path);
    if (!(file << result.dump(1) << "\n")) throw std::runtime_error("cannot write " + json_path);
  }
  std::printf("%lld %s, seed %u: %lld failures in %.0f s on %u threads\n", static_cast<long long>(done), campaign.cases,
              run.seed, static_cast<long long>(failed), seconds, run.threads);
  return failed == 0 ? 0 : 1;
}

}  // namespace

int runProgram(Campaign campaign, int argc, char** argv) {
  Run run{campaign.usual};
  run.threads = std::max(1u, std::thread::hardware_concurrency());
  std::string json_path, record_path = std::string(PROXIMITY_SOURCE_DIR) + "/test/data/" + campaign.record_file;
  const std::string cases = campaign.cases;

  tools::ProgramOptions program(campaign.program, campaign.about);
  addPositive(program, campaign.option, run.cases, "how many " + cases + ", of all families together");
  if (campaign.reference_option)
    addPositive(program, campaign.reference_option, campaign.per_reference, campaign.reference_help);
  addCount(program, "--seed", run.seed, 0, std::numeric_limits<unsigned>::max(),
           "the same seed gives the same " + cases + " (default: 1)");
  program.addText("--family", "NAME", run.family, "one family only, by its name in the table");
  addPositive(program, "--threads", run.threads, "as many as there are cores");
  program.addText("--json", "FILE", json_path, "where the table goes as JSON, for ./dev plot");
  program.addText("--record", "FILE", record_path, "where failing " + cases + " go, one line each");
  if (const std::optional<int> exit_code = program.parse(argc, argv)) return *exit_code;
  try {
    return runAndReport(campaign, run, record_path, json_path);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", campaign.program, error.what());
    return 2;
  }
}

}  // namespace proximity_server::stress
