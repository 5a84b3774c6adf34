#include "node/sources/tracked_ages.h"

#include "node/robot/query_status.h"
#include "system/durations.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::node {
namespace {

using Lock = std::lock_guard<std::mutex>;

/// [s] In floating point, because ros::Duration throws for more than 68 years and stamps may have any value.
double elapsed(const ros::Time& from, const ros::Time& to) { return to.toSec() - from.toSec(); }

/// Rounded to milliseconds.
std::string textOf(double seconds) { return system::secondsText(1e-3 * std::round(1e3 * seconds)); }

}  // namespace

void TrackedAges::follow(const Robot& robot) {
  const Lock lock(mutex_);
  const std::vector<TrackedSource>& tracked = robot.config().tracked;
  const auto is_of = [](const Entry& entry, const TrackedSource& source) { return entry.source == source; };
  if (reference_frame_ == robot.referenceFrame() &&
      std::equal(entries_.begin(), entries_.end(), tracked.begin(), tracked.end(), is_of))
    return;
  reference_frame_ = robot.referenceFrame();
  entries_.clear();
  for (const TrackedSource& source : tracked) entries_.push_back({source, {}, {}});
}

std::string TrackedAges::refusalOf(const std::string& name, const ros::Time& stamp, const ros::Time& now) {
  const Lock lock(mutex_);
  Entry* const entry = find(name);
  if (!entry) return "the source is not known any more";
  if (entry->source.isMap()) return {};
  const double max_age = entry->source.max_age, age = elapsed(stamp, now);
  if (entry->latest && elapsed(now, *entry->latest) > max_age) entry->latest.reset();
  if (-age > max_age) return "its stamp is " + textOf(-age) + " ahead of the clock";
  if (age > max_age) return "it is " + textOf(age) + " old, max_age is " + textOf(max_age);
  if (entry->latest && stamp < *entry->latest)
    return "its stamp is " + textOf(elapsed(stamp, *entry->latest)) + " before that of the message before it";
  return {};
}

void TrackedAges::accept(const std::string& name, const ros::Time& stamp, const SensedCloud& cloud) {
  const Lock lock(mutex_);
  Entry* const entry = find(name);
  if (!entry) return;
  entry->latest = stamp;
  entry->cloud = cloud;
  entry->problem.clear();
}

void TrackedAges::refuse(const std::string& name, const std::string& reason, bool is_stale) {
  const Lock lock(mutex_);
  Entry* const entry = find(name);
  if (!entry) return;
  if (is_stale) entry->latest.reset();
  entry->problem = reason;
}

QueryStatus TrackedAges::status(const ros::Time& now) const {
  const Lock lock(mutex_);
  for (const auto& [source, latest, problem, cloud] : entries_) {
    const double age = latest ? elapsed(*latest, now) : 0.0;
    if (latest && (source.isMap() || std::abs(age) <= source.max_age)) continue;
    std::string text = source.text() + " on '" + source.topic + "': ";
    if (latest && age > 0.0)
      text += "its latest message is " + textOf(age) + " old, max_age is " + textOf(source.max_age);
    else if (latest)
      text += "its latest message is " + textOf(-age) + " ahead of the clock";
    else if (problem.empty())
      text += "no message yet";
    if (!problem.empty()) text += (latest ? "; a message is left out: " : "a message is left out: ") + problem;
    return statusOf(QueryStatus::TF_STALE, text);
  }
  return {};
}

std::vector<std::optional<double>> TrackedAges::all(const ros::Time& now) const {
  const Lock lock(mutex_);
  std::vector<std::optional<double>> ages;
  for (const Entry& entry : entries_)
    ages.push_back(entry.latest ? std::optional(elapsed(*entry.latest, now)) : std::nullopt);
  return ages;
}

std::vector<SensedCloud> TrackedAges::clouds(const ros::Time& now) const {
  const Lock lock(mutex_);
  std::vector<SensedCloud> clouds;
  for (const Entry& entry : entries_) {
    if (!entry.source.sensing) continue;
    SensedCloud& cloud = clouds.emplace_back(entry.latest ? entry.cloud : SensedCloud());
    cloud.source = entry.source.name;
    if (entry.latest) cloud.age = elapsed(*entry.latest, now);
  }
  return clouds;
}

TrackedAges::Entry* TrackedAges::find(const std::string& name) {
  const auto is_it = [&](const Entry& entry) { return entry.source.name == name; };
  const auto found = std::find_if(entries_.begin(), entries_.end(), is_it);
  return found == entries_.end() ? nullptr : &*found;
}

}  // namespace proximity_server::node
