#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace proximity_server::narrowphase {

constexpr std::size_t kFailuresKept = 20;  // of a family

/// A run over families, which have a `name` and a `rarity`. In each round every family that is not too rare for it is
/// observed once.
template <typename AnyFamily>
class Rounds {
 public:
  /// At least so many observations of the families of that name; "": of all together. Throws std::invalid_argument
  /// where no family has the name.
  Rounds(const std::vector<AnyFamily>& families, const std::string& name, double observations) : families_(families) {
    double of_a_round = 0.0;
    for (std::size_t i = 0; i < families.size(); ++i) {
      if (!name.empty() && name != families[i].name) continue;
      chosen_.push_back(i);
      of_a_round += 1.0 / families[i].rarity;
    }
    if (chosen_.empty()) throw std::invalid_argument("no family is called " + name);
    rounds_ = static_cast<std::int64_t>(std::ceil(observations / of_a_round));
  }

  /// Calls observe(family, number, summary) for each observation, and returns a summary of each chosen family. The
  /// numbers of a family do not depend on the threads. A Summary has `name`, `failures` with a `number` each, and
  /// merge.
  template <typename Summary, typename Observe>
  std::vector<Summary> observe(unsigned threads, const Observe& observe) const {
    std::vector<std::vector<Summary>> seen(std::max(threads, 1u), std::vector<Summary>(chosen_.size()));
    std::atomic<std::int64_t> next{0};
    std::vector<std::thread> workers;
    for (std::vector<Summary>& own : seen) workers.emplace_back([&] { work(next, observe, own); });
    for (std::thread& worker : workers) worker.join();

    std::vector<Summary> total(chosen_.size());
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      total[i].name = families_[chosen_[i]].name;
      for (const std::vector<Summary>& own : seen) total[i].merge(own[i]);
      auto& failures = total[i].failures;
      std::sort(failures.begin(), failures.end(), [](const auto& x, const auto& y) { return x.number < y.number; });
      if (failures.size() > kFailuresKept) failures.erase(failures.begin() + kFailuresKept, failures.end());
    }
    return total;
  }

 private:
  template <typename Summary, typename Observe>
  void work(std::atomic<std::int64_t>& next, const Observe& observe, std::vector<Summary>& summaries) const {
    const auto families = static_cast<std::int64_t>(chosen_.size());
    for (std::int64_t i = next++; i < families * rounds_; i = next++) {
      const auto place = static_cast<std::size_t>(i % families);
      const std::int64_t round = i / families, rarity = families_[chosen_[place]].rarity;
      if (round % rarity == 0) observe(chosen_[place], round / rarity, summaries[place]);
    }
  }

  const std::vector<AnyFamily>& families_;
  std::vector<std::size_t> chosen_;
  std::int64_t rounds_;
};

}  // namespace proximity_server::narrowphase
