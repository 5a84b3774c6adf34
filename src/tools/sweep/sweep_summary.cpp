#include "tools/sweep/sweep_summary.h"

#include "tools/robot/robot_text.h"
#include "tools/text/csv.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr scene::ClearanceLevel kLevels[] = {scene::ClearanceLevel::Clear, scene::ClearanceLevel::Warn,
                                             scene::ClearanceLevel::Stop, scene::ClearanceLevel::Collision};

/// The counts, and their names in JSON.
struct Count {
  const char *of_distances, *of_verdicts;
  std::uint64_t SweepSummary::*count;

  const char* nameIn(SummaryKind kind) const { return kind == SummaryKind::Distances ? of_distances : of_verdicts; }
};
constexpr Count kCounts[] = {{"states", "states", &SweepSummary::states},
                             {"unknown", "unknown", &SweepSummary::unknown},
                             {"unlisted", "above", &SweepSummary::unlisted},
                             {"at_or_below_0", "below", &SweepSummary::below}};

const char* nameOfNotable(SummaryKind kind) { return kind == SummaryKind::Distances ? "worst" : "first_below"; }

/// The order of notable states: by distance, then by number.
bool precedes(const NumberedPair& a, const NumberedPair& b) {
  return a.distance < b.distance || (a.distance == b.distance && a.state < b.state);
}

Json toJson(const NotableState& state, SummaryKind kind) {
  const NumberedPair& closest = state.closest;
  Json json{{"state", closest.state}, {"link_a", state.link_a}, {"link_b", state.link_b}};
  if (kind == SummaryKind::Distances)
    json.update({{"distance", closest.distance}, {"lower", closest.lower}, {"upper", closest.upper}});
  json["positions"] = state.positions;
  return json;
}

NotableState notableFrom(const Json& json, SummaryKind kind) {
  NotableState state{{json.at("state")}, json.at("link_a"), json.at("link_b"), json.at("positions")};
  for (const auto& [joint, position] : state.positions.items()) static_cast<void>(position.get<double>());  // or throws
  if (kind == SummaryKind::Distances) {
    state.closest.distance = json.at("distance");
    state.closest.lower = json.at("lower");
    state.closest.upper = json.at("upper");
  }
  return state;
}

using PairCount = std::pair<SweepSummary::Names, std::uint64_t>;

/// The most frequent first, equals by their names.
std::vector<PairCount> byFrequency(const SweepSummary& summary) {
  std::vector<PairCount> sorted(summary.pairs.begin(), summary.pairs.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const PairCount& a, const PairCount& b) { return a.second > b.second; });
  return sorted;
}

std::string percentOf(std::uint64_t part, std::uint64_t whole) {
  const double percent = 100.0 * static_cast<double>(part) / static_cast<double>(std::max<std::uint64_t>(whole, 1));
  return shortest(std::round(10.0 * percent) / 10.0) + " %";
}

std::string inText(std::uint64_t count) { return std::to_string(count); }

std::string pairText(const std::string& a, const std::string& b) { return a + " - " + b; }

}  // namespace

void SweepSummary::add(const SweepSummary& other) {
  for (const Count& of : kCounts) this->*of.count += other.*of.count;
  for (const auto& [bin, count] : other.histogram) histogram[bin] += count;
  for (const auto& [level, count] : other.levels) levels[level] += count;
  for (const auto& [names, count] : other.pairs) pairs[names] += count;
  notable.insert(notable.end(), other.notable.begin(), other.notable.end());
  std::sort(notable.begin(), notable.end(),
            [](const auto& a, const auto& b) { return precedes(a.closest, b.closest); });
  if (notable.size() > kNotable) notable.resize(kNotable);
}

Json SweepSummary::toJson() const {
  Json json;
  for (const Count& of : kCounts) json[of.nameIn(kind)] = this->*of.count;
  if (kind == SummaryKind::Distances) json["histogram"] = Json::array();
  for (const auto& [bin, count] : histogram) json["histogram"].push_back({{"from", bin / 100.0}, {"states", count}});
  for (const auto& [level, count] : levels) json["levels"][toString(level)] = count;
  Json& listed = json[nameOfNotable(kind)] = Json::array();
  for (const NotableState& state : notable) listed.push_back(tools::toJson(state, kind));
  json["pairs"] = Json::array();
  for (const auto& [names, count] : byFrequency(*this))
    json["pairs"].push_back({{"link_a", names.first}, {"link_b", names.second}, {"states", count}});
  return json;
}

SweepSummary SweepSummary::fromJson(const Json& json) {
  SweepSummary summary;
  try {
    summary.kind = json.contains("histogram") ? SummaryKind::Distances : SummaryKind::Verdicts;
    for (const Count& of : kCounts) summary.*of.count = json.at(of.nameIn(summary.kind));
    for (const Json& bin : json.value("histogram", Json::array()))
      summary.histogram[static_cast<int>(std::lround(100.0 * bin.at("from").get<double>()))] = bin.at("states");
    for (const scene::ClearanceLevel level : kLevels)
      if (json.contains("levels") && json["levels"].contains(toString(level)))
        summary.levels[level] = json["levels"][toString(level)];
    for (const Json& state : json.at(nameOfNotable(summary.kind)))
      summary.notable.push_back(notableFrom(state, summary.kind));
    for (const Json& pair : json.at("pairs")) summary.pairs[{pair.at("link_a"), pair.at("link_b")}] = pair.at("states");
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(std::string("no summary of a sweep: ") + error.what());
  }
  return summary;
}

std::string SweepSummary::text() const {
  const bool has_distances = kind == SummaryKind::Distances;
  std::string text = inText(states) + (states == 1 ? " state" : " states");
  text += has_distances ? ", " + inText(below) + " at or below 0"
                        : ", " + inText(below) + " below (" + percentOf(below, states) + ")";
  text += ", " + inText(unknown) + " unknown";
  if (has_distances && unlisted > 0) text += ", " + inText(unlisted) + " without a listed pair";
  for (const auto& [level, count] : levels) text += ", " + inText(count) + " " + toString(level);
  if (!notable.empty()) {
    const NotableState& first = notable.front();
    text += has_distances ? "; the closest is state " + inText(first.closest.state) + " at " +
                                shortest(first.closest.distance) + " m"
                          : "; the first is state " + inText(first.closest.state);
    text += ", " + pairText(first.link_a, first.link_b);
  }
  const std::vector<PairCount> sorted = byFrequency(*this);
  if (sorted.empty()) return text;
  const auto& [names, count] = sorted.front();
  return text + "\n  most often: " + pairText(names.first, names.second) + ", in " + percentOf(count, states);
}

int SummaryCounter::binOf(double distance) {
  constexpr double kWidest = kOutermost / 100.0;
  if (distance < -kWidest) return -kOutermost - 1;
  if (distance >= kWidest) return kOutermost;
  // The product is rounded, so it may be one bin off.
  int bin = static_cast<int>(std::floor(100.0 * distance));
  if (distance < bin / 100.0) --bin;
  if (distance >= (bin + 1) / 100.0) ++bin;
  return bin;
}

void SummaryCounter::count(const NumberedPair& closest) {
  ++counts_.states;
  if (closest.pair >= 0) {
    const auto pair = static_cast<std::size_t>(closest.pair);
    if (pair >= by_pair_.size()) by_pair_.resize(pair + 1, 0);
    ++by_pair_[pair];
  }
  // Written so that a bound that is no number is not above.
  const bool is_verdict = counts_.kind == SummaryKind::Verdicts;
  if (is_verdict || !(closest.lower > 0.0)) ++counts_.below;
  if (is_verdict) return;
  ++bins_[binOf(closest.distance) + kOutermost + 1];
}

bool SummaryCounter::isNotable(const NumberedPair& closest) const {
  return notable_.size() < SweepSummary::kNotable || precedes(closest, notable_.back().closest);
}

void SummaryCounter::keep(const Notable& notable) {
  const auto place = std::find_if(notable_.begin(), notable_.end(),
                                  [&](const Notable& other) { return precedes(notable.closest, other.closest); });
  notable_.insert(place, notable);
  if (notable_.size() > SweepSummary::kNotable) notable_.pop_back();
}

SweepSummary SummaryCounter::withoutNumbers(const scene::RobotModel& robot) const {
  SweepSummary made = counts_;
  for (std::size_t i = 0; i < bins_.size(); ++i)
    if (bins_[i] > 0) made.histogram[static_cast<int>(i) - kOutermost - 1] = bins_[i];
  for (const auto& [closest, names, positions] : notable_)
    made.notable.push_back({closest, names.first, names.second, positionsJson(robot, positions)});
  return made;
}

}  // namespace proximity_server::tools
