#include "tools/sweep/sweep_summary.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/command_line/csv.h"

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr scene::ClearanceLevel kLevels[] = {scene::ClearanceLevel::Clear, scene::ClearanceLevel::Warn,
                                             scene::ClearanceLevel::Stop, scene::ClearanceLevel::Collision};

/// The order of notable states: by distance, then by number.
template <typename A, typename B>
bool precedes(const A& a, const B& b) {
  return a.distance < b.distance || (a.distance == b.distance && a.state < b.state);
}

Json toJson(const NotableState& state, SummaryKind kind) {
  Json json;
  json["state"] = state.state;
  json["link_a"] = state.link_a;
  json["link_b"] = state.link_b;
  if (kind == SummaryKind::Distances) {
    json["distance"] = state.distance;
    json["lower"] = state.lower;
    json["upper"] = state.upper;
  }
  json["positions"] = Json::object();
  for (const auto& [joint, position] : state.positions) json["positions"][joint] = position;
  return json;
}

NotableState notableFrom(const Json& json, SummaryKind kind) {
  NotableState state;
  state.state = json.at("state");
  state.link_a = json.at("link_a");
  state.link_b = json.at("link_b");
  if (kind == SummaryKind::Distances) {
    state.distance = json.at("distance");
    state.lower = json.at("lower");
    state.upper = json.at("upper");
  }
  for (const auto& [joint, position] : json.at("positions").items()) state.positions.emplace_back(joint, position);
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
  return numberText(std::round(10.0 * percent) / 10.0) + " %";
}

std::string inText(std::uint64_t count) { return std::to_string(count); }

std::string pairText(const std::string& a, const std::string& b) { return a + " - " + b; }

}  // namespace

void SweepSummary::add(const SweepSummary& other) {
  states += other.states;
  unknown += other.unknown;
  unlisted += other.unlisted;
  not_above_zero += other.not_above_zero;
  below += other.below;
  for (const auto& [bin, count] : other.histogram) histogram[bin] += count;
  for (const auto& [level, count] : other.levels) levels[level] += count;
  for (const auto& [names, count] : other.pairs) pairs[names] += count;
  notable.insert(notable.end(), other.notable.begin(), other.notable.end());
  std::sort(notable.begin(), notable.end(), [](const auto& a, const auto& b) { return precedes(a, b); });
  if (notable.size() > kNotable) notable.resize(kNotable);
}

Json SweepSummary::toJson() const {
  const bool has_distances = kind == SummaryKind::Distances;
  Json json;
  json["states"] = states;
  json["unknown"] = unknown;
  if (has_distances) {
    json["unlisted"] = unlisted;
    json["at_or_below_0"] = not_above_zero;
    json["histogram"] = Json::array();
    for (const auto& [bin, count] : histogram) json["histogram"].push_back({{"from", bin / 100.0}, {"states", count}});
  } else {
    json["above"] = unlisted;
    json["below"] = below;
  }
  for (const auto& [level, count] : levels) json["levels"][toString(level)] = count;
  Json& listed = json[has_distances ? "worst" : "first_below"] = Json::array();
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
    const bool has_distances = summary.kind == SummaryKind::Distances;
    summary.states = json.at("states");
    summary.unknown = json.at("unknown");
    summary.unlisted = json.at(has_distances ? "unlisted" : "above");
    if (has_distances) {
      summary.not_above_zero = json.at("at_or_below_0");
      for (const Json& bin : json.at("histogram"))
        summary.histogram[static_cast<int>(std::lround(100.0 * bin.at("from").get<double>()))] = bin.at("states");
    } else {
      summary.below = json.at("below");
    }
    for (const scene::ClearanceLevel level : kLevels)
      if (json.contains("levels") && json["levels"].contains(toString(level)))
        summary.levels[level] = json["levels"][toString(level)];
    for (const Json& state : json.at(has_distances ? "worst" : "first_below"))
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
  text += has_distances ? ", " + inText(not_above_zero) + " at or below 0"
                        : ", " + inText(below) + " below (" + percentOf(below, states) + ")";
  text += ", " + inText(unknown) + " unknown";
  if (has_distances && unlisted > 0) text += ", " + inText(unlisted) + " without a listed pair";
  for (const auto& [level, count] : levels) text += ", " + inText(count) + " " + toString(level);
  if (!notable.empty()) {
    const NotableState& first = notable.front();
    text += has_distances ? "; the closest is state " + inText(first.state) + " at " + numberText(first.distance) + " m"
                          : "; the first is state " + inText(first.state);
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

void SummaryCounter::count(const Closest& closest) {
  ++known_;
  const auto pair = static_cast<std::size_t>(closest.pair);
  if (pair >= by_pair_.size()) by_pair_.resize(pair + 1, 0);
  ++by_pair_[pair];
  if (kind_ == SummaryKind::Verdicts) return;
  ++bins_[static_cast<std::size_t>(binOf(closest.distance) + kOutermost + 1)];
  // Written so that a bound that is no number is not above.
  if (!(closest.lower > 0.0)) ++not_above_zero_;
}

bool SummaryCounter::isNotable(const Closest& closest) const {
  return notable_.size() < SweepSummary::kNotable || precedes(closest, notable_.back().closest);
}

void SummaryCounter::keep(const Closest& closest, const scene::Positions& positions) {
  const auto place = std::find_if(notable_.begin(), notable_.end(),
                                  [&](const Notable& other) { return precedes(closest, other.closest); });
  notable_.insert(place, Notable{closest, positions});
  if (notable_.size() > SweepSummary::kNotable) notable_.pop_back();
}

SweepSummary SummaryCounter::withoutNames(const scene::RobotModel& robot) const {
  SweepSummary made;
  made.kind = kind_;
  made.states = known_ + unknown_ + unlisted_;
  made.unknown = unknown_;
  made.unlisted = unlisted_;
  (kind_ == SummaryKind::Distances ? made.not_above_zero : made.below) =
      kind_ == SummaryKind::Distances ? not_above_zero_ : known_;
  made.levels = levels_;
  for (std::size_t i = 0; i < bins_.size(); ++i)
    if (bins_[i] > 0) made.histogram[static_cast<int>(i) - kOutermost - 1] = bins_[i];
  const auto ranges = scene::jointRanges(robot);
  for (const Notable& notable : notable_) {
    NotableState state{
        notable.closest.state, notable.closest.distance, notable.closest.lower, notable.closest.upper, "", "", {}};
    for (const scene::JointRange& range : ranges)
      state.positions.emplace_back(robot.joints[range.joint].name, notable.positions[range.joint]);
    made.notable.push_back(std::move(state));
  }
  return made;
}

}  // namespace proximity_server::tools
