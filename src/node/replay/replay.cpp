#include "node/replay/replay.h"

#include "node/answers/guarantees.h"
#include "node/replay/record_reader.h"
#include "node/robot/level_name.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

constexpr std::size_t kMostDifferences = 10;
constexpr std::int64_t kNoEnd = std::numeric_limits<std::int64_t>::max();

std::string formatted(const char* format, double number) {
  char text[64];
  std::snprintf(text, sizeof text, format, number);
  return text;
}

PoseSnapshot snapshotOf(const RecordedCycle& cycle) {
  PoseSnapshot snapshot;
  snapshot.poses = cycle.poses;
  snapshot.stamp = cycle.clearance.header.stamp;
  snapshot.age = cycle.clearance.tf_age;
  snapshot.skew = cycle.clearance.tf_skew;
  if (cycle.clearance.level == Clearance::INVALID) snapshot.status = cycle.clearance.status;
  return snapshot;
}

std::string namesOf(const Proximity& pair) { return pair.a.link + " - " + pair.b.link; }

/// "" if the bounds of the closest pair overlap, and the levels are the same.
std::string differenceOf(const Clearance& now, const Clearance& before) {
  if (now.level != before.level)
    return std::string(levelName(now.level)) + ", in the record " + levelName(before.level) + "; " +
           now.status.message + ", in the record " + before.status.message;
  if (now.level == Clearance::INVALID) return {};
  const Proximity &p = now.minimum, &q = before.minimum;
  if (p.lower_bound <= q.upper_bound + kRoundingOfMessages && q.lower_bound <= p.upper_bound + kRoundingOfMessages)
    return {};
  return "the closest pair " + namesOf(p) + " is at " + formatted("%.9g", p.distance) + " m, in the record " +
         namesOf(q) + " at " + formatted("%.9g", q.distance) + " m";
}

void writeRow(std::ostream& rows, const Clearance& now, const Clearance& before) {
  char stamp[32];
  std::snprintf(stamp, sizeof stamp, "%u.%09u", now.header.stamp.sec, now.header.stamp.nsec);
  rows << stamp << ',' << levelName(now.level) << ',' << levelName(before.level) << ',' << now.deciding.a.link << ','
       << now.deciding.b.link;
  for (const double number : {now.deciding.distance, now.deciding.guaranteed, now.minimum.lower_bound,
                              now.minimum.upper_bound, before.minimum.lower_bound, before.minimum.upper_bound})
    rows << ',' << formatted("%.17g", number);
  rows << '\n';
}

/// The differences between now and the time of the record.
std::vector<std::string> reasonsOf(const RecordReader& reader, const ReplayOptions& options) {
  std::vector<std::string> reasons;
  if (reader.record.version != PROXIMITY_VERSION)
    reasons.push_back("the record is of version " + reader.record.version + ", this is " PROXIMITY_VERSION);
  if (options.mesh_tolerance)
    reasons.push_back("the mesh tolerance is " + formatted("%g", *options.mesh_tolerance) + " m");
  if (reader.robot->config().pose_latency == PoseLatency::Velocity)
    reasons.push_back("pose_latency is velocity: a record has no velocities of joint_states");
  if (reader.robot->config().isSensing()) reasons.push_back("a record has nothing of sensed sources");
  reasons.push_back("meshes are read from where they are now, and may have changed");
  return reasons;
}

/// The shape of a message; -1 as an index if there is none of this name.
scene::ShapeRef refOf(const ShapeRef& message, const Robot& robot, const scene::Objects& objects) {
  if (message.kind == ShapeRef::OBJECT) return scene::ShapeRef::ofObject(objects.find(message.link));
  return {robot.robotModel().findLink(message.link)};
}

/// The level whose begin is the event of this name; nullopt of the service.
std::optional<std::uint8_t> levelOfEvent(const std::string& event) {
  if (event == "stop") return Clearance::STOP;
  if (event == "collision") return Clearance::COLLISION;
  if (event == "invalid") return Clearance::INVALID;
  return std::nullopt;
}

/// The cycle of the event: one in which its level begins, or any for the service, the nearest in time. The times of the
/// bag do not jump back with the clock, so they count only where there are no stamps of tf.
struct EventCycle {
  RecordedCycle cycle;
  std::string event;
};
EventCycle eventOf(const ReplayOptions& options) {
  EventCycle found;
  std::optional<std::uint8_t> before;
  double smallest = std::numeric_limits<double>::infinity();
  RecordReader reader(options.file, {options.mesh_tolerance});
  reader.read([&](const RecordedCycle& cycle) {
    const Clearance& clearance = cycle.clearance;
    const std::optional<std::uint8_t> level = levelOfEvent(reader.record.event);
    const bool begins = !level || (clearance.level == *level && before && before != level);
    before = clearance.level;
    const ros::Time time = clearance.header.stamp.isZero() ? cycle.time : clearance.header.stamp + clearance.tf_age;
    const double difference = std::abs((time - reader.record.event_stamp).toSec());
    if (!found.event.empty() && !(begins && difference <= smallest)) return;
    if (begins) smallest = difference;
    found = {cycle, reader.record.event};
  });
  return found;
}

/// [m] The distance of the pair that set the level, for a variant of the robot.
double distanceOf(const ReplayOptions& options, const RobotVariant& variant, const RecordedCycle& event) {
  double distance = kNaN;
  RecordReader reader(options.file, variant);
  reader.read([&](const RecordedCycle& cycle) {
    if (cycle.clearance.cycle != event.clearance.cycle) return;
    const ScenePool::Lease scenes = reader.robot->borrowScenes();
    scene::State& state = scenes->state;
    state.set(reader.objects.objects.all);
    if (cycle.frames.size() == reader.objects.frames.names.size())
      state.set(cycle.poses, cycle.frames);
    else
      state.set(cycle.poses);
    const scene::Objects& objects = *reader.objects.objects.all;
    const Proximity& pair = event.clearance.deciding;
    const scene::ShapeRefPair refs{refOf(pair.a, *reader.robot, objects), refOf(pair.b, *reader.robot, objects)};
    distance = scenes->scene.proximity(state, refs).result.distance;
  });
  return distance;
}

}  // namespace

ReplayResult replay(const ReplayOptions& options, std::ostream& rows) {
  ReplayResult result;
  Monitor monitor;
  std::uint64_t expected = 0;  // number of the next cycle; the first one has 1
  RecordReader reader(options.file, {options.mesh_tolerance});
  rows << "stamp,level,recorded_level,link_a,link_b,distance,guaranteed,minimum_lower,minimum_upper,"
          "recorded_minimum_lower,recorded_minimum_upper\n";
  reader.read([&](const RecordedCycle& cycle) {
    if (reader.is_new) {
      if (monitor.robot() != reader.robot) monitor.follow(reader.robot);
      MonitoredObjects objects = reader.objects;
      monitor.use(objects);
    }
    // Hysteresis may hold a level of a cycle that is not in the record.
    if (cycle.clearance.cycle != expected) monitor.assumeLevel(cycle.clearance.level);
    expected = cycle.clearance.cycle + 1;
    MonitorSettings settings = cycle.settings;
    settings.lookahead = 0.0;
    monitor.endTimeAfter(stepsOfTimeOver(cycle.clearance.status.message).value_or(kNoEnd));
    const Clearance& now = monitor.cycle(snapshotOf(cycle), {}, settings, {cycle.frames, {}, {}});
    writeRow(rows, now, cycle.clearance);
    ++result.cycles;
    const std::string number = "cycle " + std::to_string(cycle.clearance.cycle) + ": ";
    const std::string end = endIn(cycle.clearance.status.message);
    if (!end.empty() && ++result.coarse <= kMostDifferences) result.first_coarse.push_back(number + end);
    const std::string difference = differenceOf(now, cycle.clearance);
    if (difference.empty()) return;
    ++result.different;
    if (result.first_differences.size() < kMostDifferences) result.first_differences.push_back(number + difference);
  });
  result.reasons = reasonsOf(reader, options);
  return result;
}

std::string explainEvent(const ReplayOptions& options) {
  const EventCycle found = eventOf(options);
  const Clearance& clearance = found.cycle.clearance;
  if (clearance.level == Clearance::INVALID)
    return found.event + ": no pair, the level is INVALID: " + clearance.status.message + "\n";
  const auto share = [](const char* what, double metres) {
    return formatted("  %8.3f mm  ", 1000.0 * metres) + what + "\n";
  };
  const double decided =
      clearance.level == Clearance::COLLISION ? clearance.deciding.distance : clearance.deciding.guaranteed;
  const double distance = distanceOf(options, {options.mesh_tolerance, true}, found.cycle);
  const double bare = distanceOf(options, {options.mesh_tolerance, false}, found.cycle);
  const double surfaces = distanceOf(options, {0.0, false}, found.cycle);
  const double threshold = clearance.deciding_threshold;
  std::string text = found.event + ": " + levelName(clearance.level) + ": " + clearance.status.message + "\n";
  text += share("distance that decided", decided) + share("uncertainty", distance - decided) +
          share("padding", bare - distance) + share("pieces in place of meshes", surfaces - bare) +
          share("distance of the surfaces of the model", surfaces);
  if (clearance.level == Clearance::CLEAR) return text + "clear: the pair is beyond all thresholds\n";
  const char* const verdict = surfaces <= 0.0         ? "contact: the surfaces of the model touch or overlap"
                              : surfaces <= threshold ? "near: the surfaces themselves are within the threshold of "
                                                      : "envelope: without it the pair is beyond the threshold of ";
  return text + verdict + (surfaces <= 0.0 ? "" : formatted("%.4g mm", 1000.0 * threshold)) + "\n";
}

}  // namespace proximity_server::node
