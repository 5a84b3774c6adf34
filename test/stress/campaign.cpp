#include "stress/campaign.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <thread>

namespace proximity_server::stress {
namespace {

/// The families that take part, by their places, and the rounds.
struct Schedule {
  std::vector<std::size_t> chosen;
  std::int64_t rounds;

  Schedule(const Campaign& campaign, const Run& run) {
    double of_a_round = 0.0;
    for (std::size_t i = 0; i < campaign.families.size(); ++i) {
      if (!run.family.empty() && run.family != campaign.families[i].name) continue;
      chosen.push_back(i);
      of_a_round += 1.0 / campaign.families[i].rarity;
    }
    if (chosen.empty()) throw std::invalid_argument("no family is called " + run.family);
    rounds = static_cast<std::int64_t>(std::ceil(static_cast<double>(run.cases) / campaign.cases_of_part / of_a_round));
  }
};

void work(const Campaign& campaign, const Run& run, const Schedule& schedule, std::atomic<std::int64_t>& next,
          std::atomic<std::int64_t>& done, std::vector<Tally>& tallies) {
  const auto families = static_cast<std::int64_t>(schedule.chosen.size());
  for (std::int64_t i = next++; i < families * schedule.rounds; i = next++) {
    const auto place = static_cast<std::size_t>(i % families);
    const std::size_t family = schedule.chosen[place];
    const std::int64_t round = i / families, rarity = campaign.families[family].rarity;
    if (round % rarity != 0) continue;
    Tally& tally = tallies[place];
    const double before = tally[campaign.cases];
    campaign.ask({run.seed, family, round / rarity, campaign.per_reference}, tally);
    done += static_cast<std::int64_t>(tally[campaign.cases] - before);
  }
}

}  // namespace

Tally::Entry& Tally::entry(const std::string& name, Kind kind) {
  const double first = kind == Kind::Smallest ? std::numeric_limits<double>::infinity() : 0.0;
  return entries_.try_emplace(name, Entry{kind, first, {}}).first->second;
}

void Tally::raise(const std::string& name, double number) {
  double& largest = entry(name, Kind::Largest).value;
  largest = std::max(largest, number);
}

void Tally::lower(const std::string& name, double number) {
  double& smallest = entry(name, Kind::Smallest).value;
  smallest = std::min(smallest, number);
}

void Tally::fail(const Failure& failure) {
  ++failed_;
  if (failures_.size() < kFailuresKept) failures_.push_back(failure);
}

double Tally::operator[](const std::string& name) const {
  const auto found = entries_.find(name);
  return found == entries_.end() ? 0.0 : found->second.value;
}

double Tally::quantile(const std::string& name, double share) const {
  const auto found = entries_.find(name);
  if (found == entries_.end()) return 0.0;
  std::vector<double> samples = found->second.samples;
  const auto place = samples.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(samples.size() - 1));
  std::nth_element(samples.begin(), place, samples.end());
  return *place;
}

std::map<std::string, double> Tally::numbers() const {
  std::map<std::string, double> result{{"failures", static_cast<double>(failed_)}};
  for (const auto& [name, entry] : entries_)
    result[name] = entry.kind == Kind::Sample ? quantile(name, 0.5) : entry.value;
  return result;
}

void Tally::merge(const Tally& other) {
  for (const auto& [name, theirs] : other.entries_) {
    Entry& ours = entry(name, theirs.kind);
    if (ours.kind == Kind::Sum) ours.value += theirs.value;
    if (ours.kind == Kind::Largest) ours.value = std::max(ours.value, theirs.value);
    if (ours.kind == Kind::Smallest) ours.value = std::min(ours.value, theirs.value);
    ours.samples.insert(ours.samples.end(), theirs.samples.begin(), theirs.samples.end());
  }
  failed_ += other.failed_;
  failures_.insert(failures_.end(), other.failures_.begin(), other.failures_.end());
  std::sort(failures_.begin(), failures_.end(), [](const Failure& x, const Failure& y) { return x.number < y.number; });
  if (failures_.size() > kFailuresKept) failures_.resize(kFailuresKept);
}

Column number(const char* head, int width, const char* format, const char* name) {
  return {head, width, format, [name](const Tally& tally) { return tally[name]; }};
}

Column count(const char* head, int width, const char* name) { return number(head, width, "%*.0f", name); }

Column failures(int width) {
  return {"failures", width, "%*.0f", [](const Tally& tally) { return static_cast<double>(tally.failed()); }};
}

Column ratio(const char* head, int width, const char* format, const char* sum, const char* over, double factor) {
  return {head, width, format, [=](const Tally& tally) { return factor * tally[sum] / std::max(1.0, tally[over]); }};
}

void printHead(const char* rows, int width, const std::vector<Column>& columns) {
  std::printf("%-*s", width, rows);
  for (const Column& column : columns) std::printf(" %*s", column.width, column.head);
  std::printf("\n");
}

void printRow(int width, const std::vector<Column>& columns, const Tally& tally) {
  std::printf("%-*s", width, tally.family.c_str());
  for (const Column& column : columns) {
    std::printf(" ");
    std::printf(column.format, column.width, column.value(tally));
  }
  std::printf("\n");
}

std::vector<Tally> observe(const Campaign& campaign, const Run& run, std::atomic<std::int64_t>& done) {
  const Schedule schedule(campaign, run);
  const unsigned threads = run.threads > 0 ? run.threads : std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::vector<Tally>> seen(threads, std::vector<Tally>(schedule.chosen.size()));
  std::atomic<std::int64_t> next{0};
  std::vector<std::thread> workers;
  for (std::vector<Tally>& own : seen) workers.emplace_back([&] { work(campaign, run, schedule, next, done, own); });
  for (std::thread& worker : workers) worker.join();

  std::vector<Tally> total(schedule.chosen.size());
  for (std::size_t i = 0; i < total.size(); ++i) {
    total[i].family = campaign.families[schedule.chosen[i]].name;
    for (const std::vector<Tally>& own : seen) total[i].merge(own[i]);
  }
  return total;
}

std::vector<Tally> observe(const Campaign& campaign, const Run& run) {
  std::atomic<std::int64_t> done{0};
  return observe(campaign, run, done);
}

}  // namespace proximity_server::stress
