#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ratio>
#include <vector>

namespace proximity_server::benchmark {

using Clock = std::chrono::steady_clock;

/// Runs a step, and returns how long it takes in a unit like std::micro.
template <typename Unit, typename Step>
double timeOf(const Step& step) {
  const auto start = Clock::now();
  step();
  return std::chrono::duration<double, Unit>(Clock::now() - start).count();
}

/// Returns the processor time [s] of this process: other work of the machine hardly counts.
inline double processorSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// timeOf() by the processor time of this process.
template <typename Unit, typename Step>
double processorTimeOf(const Step& step) {
  const double start = processorSeconds();
  step();
  return (processorSeconds() - start) * Unit::den / Unit::num;
}

/// Returns the value that `share` (0 to 1) of the values do not exceed; 0 if there are none.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const double place = std::ceil(share * static_cast<double>(values.size())) - 1.0;
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::max(place, 0.0));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

inline double medianOf(const std::vector<double>& values) { return quantile(values, 0.5); }

/// The times of some items over several rounds. The median of an item counts, as the machine drifts.
class Rounds {
 public:
  explicit Rounds(std::size_t items = 0) : times_(items) {}

  void add(std::size_t item, double time) { times_[item].push_back(time); }

  /// Returns the medians of the items that were timed.
  std::vector<double> medians() const {
    std::vector<double> medians;
    for (const std::vector<double>& rounds : times_)
      if (!rounds.empty()) medians.push_back(medianOf(rounds));
    return medians;
  }

 private:
  std::vector<std::vector<double>> times_;  // by item and round
};

}  // namespace proximity_server::benchmark
