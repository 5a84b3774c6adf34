#include "node/tf/frame_health.h"

#include "node/tf/edge_transforms.h"
#include "system/durations.h"
#include "system/number_text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

namespace proximity_server::node {
namespace {

constexpr std::size_t kLongestChain = 1000;  // [frames] as in tf2
constexpr std::size_t kMaxSources = 4;       // no more parents or publishers of a frame are known
/// [ns] After this pause a parent or a publisher that comes again counts as a new one.
constexpr std::int64_t kPause = 2'000'000'000;
/// A rate counts as the monitor's from this share of it on, because stamps and drivers' rates are rounded.
constexpr double kFullRate = 0.9;

std::int64_t nanoseconds(const ros::Time& time) { return static_cast<std::int64_t>(time.toNSec()); }

/// A time [ns] for a message, rounded to milliseconds: "0.512 s".
std::string text(std::int64_t time) { return system::secondsText(1e-3 * std::round(1e-6 * static_cast<double>(time))); }

/// The steps from a frame to the root of its tree.
std::vector<TfEdge> wayUp(const tf2::BufferCore& buffer, const std::string& frame) {
  std::vector<TfEdge> way;
  TfEdge step{"", frame, ""};
  while (way.size() < kLongestChain && buffer._getParent(step.child, ros::Time(), step.parent)) {
    way.push_back(step);
    step.child = step.parent;
  }
  return way;
}

/// The steps between the ends of an edge, each from a frame to its parent.
std::vector<TfEdge> stepsOf(const tf2::BufferCore& buffer, const TfEdge& edge) {
  std::vector<TfEdge> steps = wayUp(buffer, edge.child), others = wayUp(buffer, edge.parent);
  while (!steps.empty() && !others.empty() && steps.back().child == others.back().child) {
    steps.pop_back();
    others.pop_back();
  }
  steps.insert(steps.end(), others.begin(), others.end());
  return steps;
}

/// Adds the first sentence, with the number of the others.
void addFirst(const std::vector<std::string>& sentences, std::vector<std::string>& result) {
  if (sentences.empty()) return;
  const std::size_t others = sentences.size() - 1;
  const std::string more = others > 0 ? " (and " + std::to_string(others) + " more)" : "";
  result.push_back(system::readable(sentences.front() + more));
}

}  // namespace

void FrameHealth::add(const tf2_msgs::TFMessage& message, const std::string& publisher, const ros::Time& now) {
  const Nanoseconds arrived = nanoseconds(now);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    const std::string& child = transform.child_frame_id;
    const Nanoseconds stamp = nanoseconds(transform.header.stamp);
    const bool has_slash = !child.empty() && child.front() == '/';  // tf1 allowed it
    const auto [entry, is_new] = has_slash ? frames_.try_emplace(child.substr(1)) : frames_.try_emplace(child);
    Frame& frame = entry->second;
    if (is_new) frame = {stamp, arrived, arrived, stamp, 0, {}, {}};
    frame.arrived = arrived;
    if (stamp != frame.stamp) {
      frame.stamp = stamp;
      frame.moved = arrived;
      ++frame.count;
    }
    note(transform.header.frame_id, arrived, frame.parents);
    note(publisher, arrived, frame.publishers);
  }
}

void FrameHealth::note(const std::string& name, Nanoseconds now, std::vector<Source>& sources) {
  for (Source& source : sources) {
    if (source.name != name) continue;
    if (now - source.last > kPause) source.first = now;
    source.last = now;
    return;
  }
  const auto is_gone = [&](const Source& source) { return now - source.last > kPause; };
  sources.erase(std::remove_if(sources.begin(), sources.end(), is_gone), sources.end());
  if (sources.size() < kMaxSources) sources.push_back({name, now, now});
}

void FrameHealth::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  frames_.clear();
}

std::string FrameHealth::causeOf(const tf2::BufferCore& buffer, const TfEdge& edge, const ros::Time& now) const {
  ros::Time oldest;
  std::string name;
  for (const TfEdge& step : stepsOf(buffer, edge)) {
    const ros::Time stamp = lookUpEdge(buffer, step, ros::Time()).stamp;
    if (stamp.isZero() || (!name.empty() && stamp >= oldest)) continue;
    oldest = stamp;
    name = step.child;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto entry = frames_.find(name);
  if (entry == frames_.end()) return {};
  const Frame& frame = entry->second;
  const std::string come = "messages of frame '" + name + "' come, but ";
  if (frame.stamp == 0) return come + "without a stamp";
  if (frame.stamp > nanoseconds(oldest)) return come + "tf refuses their transforms";
  const Nanoseconds silence = nanoseconds(now) - frame.arrived;
  const Nanoseconds standstill = frame.arrived - frame.moved;
  const Nanoseconds delay = frame.moved - frame.stamp;
  if (delay > std::max(silence, standstill)) return come + "their stamps are " + text(delay) + " behind the clock";
  if (silence >= standstill) return "no message of frame '" + name + "' has come for " + text(silence);
  std::string stamp;
  system::appendFixed(stamp, 1e-9 * static_cast<double>(frame.stamp), 3);
  return come + "their stamp stands still at " + stamp;
}

/// Two sources that come by turns; "" if there are none.
std::string FrameHealth::twoOf(const std::vector<Source>& sources, Nanoseconds now) {
  for (const Source& a : sources) {
    for (const Source& b : sources) {
      const bool by_turns = a.first < b.first && b.first < a.last;
      const bool are_recent = now - std::min(a.last, b.last) <= kPause;
      if (by_turns && are_recent) return "'" + a.name + "' and '" + b.name + "'";
    }
  }
  return {};
}

/// The rate [Hz] of new stamps since the previous call; infinity if it is not known.
double FrameHealth::takeRate(Frame& frame) {
  const double time = 1e-9 * static_cast<double>(frame.stamp - frame.counted_from);
  const double rate = frame.count > 0 && time > 0.0 ? frame.count / time : INFINITY;
  frame.count = 0;
  frame.counted_from = frame.stamp;
  return rate;
}

std::vector<std::string> FrameHealth::warnings(const tf2::BufferCore& buffer, const Robot& robot,
                                               const std::vector<int>& edges, double rate, const ros::Time& now) {
  std::set<std::string> needed;
  for (const int edge : edges)
    for (const TfEdge& step : stepsOf(buffer, (*robot.tfEdges())[edge])) needed.insert(step.child);
  std::vector<std::string> of_publishers, of_parents, of_rates;
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const std::string& name : needed) {
    const auto entry = frames_.find(name);
    if (entry == frames_.end()) continue;
    Frame& frame = entry->second;
    const std::string publishers = twoOf(frame.publishers, nanoseconds(now));
    if (!publishers.empty()) of_publishers.push_back("frame '" + name + "' has two publishers: " + publishers);
    const std::string parents = twoOf(frame.parents, nanoseconds(now));
    if (!parents.empty()) of_parents.push_back("frame '" + name + "' has two parents: " + parents);
    const double found = takeRate(frame);
    if (found >= kFullRate * rate) continue;
    std::string numbers;
    system::appendRounded(numbers, found, 3);
    numbers += " Hz, the monitor runs at ";
    system::appendRounded(numbers, rate, 3);
    of_rates.push_back("frame '" + name + "' comes at " + numbers + " Hz");
  }
  std::vector<std::string> result;
  for (const auto* sentences : {&of_publishers, &of_parents, &of_rates}) addFirst(*sentences, result);
  return result;
}

}  // namespace proximity_server::node
