#include "node/record/recorder.h"

#include "node/answers/conversions.h"
#include "node/objects/object_needs.h"
#include "node/record/bag_file.h"
#include "system/whole_file.h"

#include <ros/console.h>
#include <std_msgs/String.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace proximity_server::node {
namespace {

namespace fs = std::filesystem;
using Lock = std::unique_lock<std::mutex>;
using Matrix = Eigen::Matrix<double, 3, 4>;  ///< of a pose; NaN if it is not known

constexpr std::chrono::milliseconds kPause{50};  ///< until the writing thread looks again
constexpr double kKeptLonger = 60.0;             ///< [s] objects are kept for entries that a slow disk delays
constexpr std::size_t kMostKnown = 10000;        ///< revisions of objects
constexpr int kNiceness = 10;                    ///< of the writing thread
constexpr double kMegabyte = 1e6;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// The folder of the parameter; without one, the folder of ROS for files of nodes.
std::string folderOf(const Config& config) {
  if (!config.record_directory.empty()) return config.record_directory;
  if (const char* home = std::getenv("ROS_HOME")) return std::string(home) + "/proximity_server";
  const char* home = std::getenv("HOME");
  return std::string(home ? home : "/tmp") + "/.ros/proximity_server";
}

/// "proximity_server" or "arm_proximity_server" of "/arm/proximity_server".
std::string prefixOf(const std::string& node) {
  std::string prefix = node.substr(std::min(node.size(), node.find_first_not_of('/')));
  std::replace(prefix.begin(), prefix.end(), '/', '_');
  return prefix + "_";
}

bool has(const Config& config, const std::string& event) {
  const std::vector<std::string>& events = config.record_on;
  if (config.record_directory.empty()) return false;
  return events.empty() || std::find(events.begin(), events.end(), event) != events.end();
}

/// Throws std::invalid_argument if no file can be made in a folder, on a disk with room.
void requireFolder(const std::string& folder) {
  if (access((folder + "/").c_str(), W_OK | X_OK) != 0)
    throw std::invalid_argument("record_directory: " + folder + " cannot be written into" + system::because(errno));
}

static_assert(std::is_trivially_copyable_v<MonitorSettings>, "the ring copies its bytes");

std::uint8_t* put(std::uint8_t* place, const void* bytes, std::size_t size) {
  std::memcpy(place, bytes, size);
  return place + size;
}

/// BodyPoses and FramePoses are the same type.
std::uint8_t* put(std::uint8_t* place, const scene::BodyPoses& poses) {
  for (const std::optional<Eigen::Isometry3d>& pose : poses) {
    const Matrix matrix = pose ? Matrix(pose->matrix().topRows<3>()) : Matrix::Constant(kNaN);
    place = put(place, matrix.data(), sizeof(double) * Matrix::SizeAtCompileTime);
  }
  return place;
}

const std::uint8_t* get(const std::uint8_t* place, std::size_t count, scene::BodyPoses& poses) {
  poses.assign(count, std::nullopt);
  for (std::optional<Eigen::Isometry3d>& pose : poses) {
    Matrix matrix;
    constexpr std::size_t kSize = sizeof(double) * Matrix::SizeAtCompileTime;
    std::memcpy(matrix.data(), place, kSize);
    place += kSize;
    if (!matrix.allFinite()) continue;
    pose = Eigen::Isometry3d::Identity();
    pose->matrix().topRows<3>() = matrix;
  }
  return place;
}

/// A stream for roscpp that relies on there being room. If all calls are inlined, its place stays in a register: that
/// halves the instructions of a cycle, which are 2.6 % of the instructions of Monitor::cycle() for the robot of the
/// demo, 3.0 % for a Panda and 0.24 % for a PR2 (callgrind, g++ 12, 2026-11-27).
struct UncheckedStream {
  std::uint8_t* place;

  std::uint8_t* advance(std::uint32_t bytes) { return std::exchange(place, place + bytes); }
  template <class Value>
  void next(const Value& value) {
    ros::serialization::serialize(*this, value);
  }
  void next(const Proximity& pair) { place = put(place, pair); }

 private:
  [[gnu::flatten, gnu::noinline]] static std::uint8_t* put(std::uint8_t* place, const Proximity& pair) {
    UncheckedStream stream{place};
    ros::serialization::serialize(stream, pair);
    return stream.place;
  }
};

}  // namespace

/// A record that is being written.
class Recorder::Writing {
 public:
  Writing(const std::string& path, const std::string& node, Event event)
      : bag_(path), topics_(node), event_(std::move(event)) {}

  /// `known` are the robot and the objects of the entry.
  void add(const Entry& entry, const ObjectStore::CurrentObjects& known) {
    const RecordedCycle& cycle = entry.cycle;
    const Robot& robot = *known.robot;
    // Readers sort by the time, so each message has a later one, also while the clock stands still or jumps back.
    const auto write = [&](const std::string& topic, const auto& message) {
      time_ = std::max(cycle.time, time_ + ros::Duration(0, 1));
      bag_.write(topic, time_, message);
    };
    if (robot_ != known.robot) write(topics_.robot, recordOf(robot, event_.name, event_.stamp));
    if (robot_ != known.robot || objects_ != known.objects.all) {
      std_msgs::String text;
      text.data = scene::yamlOf(ObjectStore::fileOf(known));
      write(topics_.objects, text);
    }
    const dynamic_reconfigure::Config settings = toMessage(cycle.settings);
    if (!(settings == settings_)) write(topics_.settings, settings);
    joints_ = jointsOf(robot, cycle, joints_);
    if (!joints_.name.empty()) write(topics_.joints, joints_);
    write(topics_.poses, posesOf(robot, framesOf(*known.objects.all).names, cycle));
    write(topics_.clearance, cycle.clearance);
    robot_ = known.robot;
    objects_ = known.objects.all;
    settings_ = settings;
  }

  void complete() {
    if (!robot_) throw std::invalid_argument("nothing is recorded: no cycle of the monitor");
    bag_.complete();
  }

 private:
  BagFile bag_;
  const RecordTopics topics_;
  const Event event_;
  std::shared_ptr<const Robot> robot_;
  std::shared_ptr<const scene::Objects> objects_;
  dynamic_reconfigure::Config settings_;
  ros::Time time_;  ///< of the latest message
  sensor_msgs::JointState joints_;
};

Recorder::Recorder(const Config& config, std::string node)
    : node_(std::move(node)),
      folder_(folderOf(config)),
      prefix_(prefixOf(node_)),
      has_default_folder_(config.record_directory.empty()),
      seconds_(config.record_seconds),
      count_(static_cast<std::size_t>(config.record_count)),
      on_stop_(has(config, "stop")),
      on_collision_(has(config, "collision")),
      on_invalid_(has(config, "invalid")),
      ring_(seconds_ > 0.0 ? static_cast<std::size_t>(kMegabyte * config.record_memory) : 0) {
  if (seconds_ == 0.0) return;
  if (!has_default_folder_) requireFolder(folder_);
  thread_ = std::thread([this] { run(); });
}

void Recorder::stop() {
  if (!thread_.joinable()) return;
  {
    const Lock lock(mutex_);
    is_stopping_ = true;
  }
  thread_.join();
}

void Recorder::know(const ObjectStore::CurrentObjects& objects) {
  if (seconds_ == 0.0) return;
  const Lock lock(mutex_);
  known_.push_back({objects, now()});
  forget();
}

/// Forgets what no entry needs any more. The mutex is locked.
void Recorder::forget() {
  const double oldest = now() - seconds_ - kSecondsAfter - kKeptLonger;
  while (known_.size() > 1 && (known_[1].at < oldest || known_.size() > kMostKnown)) known_.pop_front();
}

void Recorder::add(const Robot& robot, const PoseSnapshot& snapshot, const FrameSnapshot& frames,
                   const Clearance& clearance, const MonitorSettings& settings) {
  if (seconds_ == 0.0) return;
  const ros::Time time = ros::Time::now();
  const Head head{now(), time.sec, time.nsec, &robot, snapshot.poses.size(), frames.poses.size(), settings};
  const std::size_t poses = (head.bodies + head.frames) * sizeof(double) * Matrix::SizeAtCompileTime;
  const std::uint32_t size = ros::serialization::serializationLength(clearance);
  if (std::uint8_t* place = reserve(sizeof head + poses + size)) {
    place = put(put(put(place, &head, sizeof head), snapshot.poses), frames.poses);
    UncheckedStream stream{place};
    ros::serialization::serialize(stream, clearance);
    ring_.commit();
  } else {
    ++lost_;
  }
  const bool is_new = level_ && *level_ != clearance.level;
  level_ = clearance.level;
  if (!is_new) return;
  if (on_stop_ && clearance.level == Clearance::STOP) save("stop", time);
  if (on_collision_ && clearance.level == Clearance::COLLISION) save("collision", time);
  if (on_invalid_ && clearance.level == Clearance::INVALID) save("invalid", time);
}

/// A place in the ring; nullptr if there is none. The oldest entries make room unless the writing thread takes them.
std::uint8_t* Recorder::reserve(std::size_t bytes) {
  for (;;) {
    std::uint8_t* const place = ring_.reserve(bytes);
    if (place || is_saving_.load(std::memory_order_acquire) || !ring_.front().data) return place;
    ring_.pop();
  }
}

void Recorder::save(const char* event, const ros::Time& stamp) {
  if (is_saving_.load(std::memory_order_acquire)) return;
  event_.name = event;  // so short that it needs no memory
  event_.at = now();
  event_.stamp = stamp;
  is_saving_.store(true, std::memory_order_release);
}

bool Recorder::beginSaving() {
  if (seconds_ == 0.0) return false;
  save("service", ros::Time::now());
  return true;
}

Recorder::Outcome Recorder::outcome() const {
  const Lock lock(mutex_);
  Outcome outcome = outcome_;
  outcome.lost = lost_;
  return outcome;
}

Recorder::Outcome Recorder::await() {
  {
    Lock lock(mutex_);
    const std::uint64_t before = records_;
    ended_.wait(lock, [&] { return records_ != before || !is_saving_ || is_stopping_; });
  }
  return outcome();
}

Recorder::Entry Recorder::entryOf(const RecordRing::Entry& bytes) {
  Entry entry;
  std::memcpy(&entry.head, bytes.data, sizeof entry.head);
  entry.cycle.time = ros::Time(entry.head.sec, entry.head.nsec);
  entry.cycle.settings = entry.head.settings;
  const std::uint8_t* place = get(bytes.data + sizeof entry.head, entry.head.bodies, entry.cycle.poses);
  place = get(place, entry.head.frames, entry.cycle.frames);
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(place),
                                     static_cast<std::uint32_t>(bytes.data + bytes.size - place));
  ros::serialization::deserialize(stream, entry.cycle.clearance);
  return entry;
}

std::optional<ObjectStore::CurrentObjects> Recorder::find(const Head& head, std::uint64_t revision) const {
  const Lock lock(mutex_);
  for (const Known& known : known_)
    if (known.objects.robot.get() == head.robot && known.objects.objects.revision == revision) return known.objects;
  return std::nullopt;
}

bool Recorder::isEnding() const {
  const Lock lock(mutex_);
  return is_stopping_;
}

void Recorder::run() {
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kNiceness);  // on Linux the priority of this thread
  for (bool is_last = false; !is_last;) {
    is_last = isEnding();
    if (!is_saving_.load(std::memory_order_acquire)) {
      if (!is_last) std::this_thread::sleep_for(kPause);
      const Lock lock(mutex_);
      forget();
      continue;
    }
    Outcome outcome;
    try {
      outcome.file = write();
      ROS_INFO_STREAM("recorded: " << outcome.file);
      removeOldest();
    } catch (const std::exception& error) {
      outcome.problem = error.what();
      ROS_ERROR_STREAM("no record: " << outcome.problem);
    }
    const Lock lock(mutex_);
    if (outcome.file.empty()) outcome.file = outcome_.file;
    outcome_ = outcome;
    ++records_;
    is_saving_.store(false, std::memory_order_release);
    ended_.notify_all();
  }
}

/// Writes one record, and returns its file.
std::string Recorder::write() {
  const std::string path = folder_ + "/" + fileName();
  system::removeLeftOvers(folder_, prefix_);
  if (has_default_folder_) fs::create_directories(folder_);
  Writing writing(path, node_, event_);
  for (;;) {
    const bool is_ending = isEnding();
    const RecordRing::Entry bytes = ring_.front();
    if (!bytes.data) {
      if (is_ending || now() > event_.at + kSecondsAfter) break;
      std::this_thread::sleep_for(kPause);
      continue;
    }
    const Entry entry = entryOf(bytes);
    if (entry.head.at > event_.at + kSecondsAfter) break;
    if (entry.head.at >= event_.at - seconds_)
      if (const auto known = find(entry.head, entry.cycle.clearance.objects_revision)) writing.add(entry, *known);
    ring_.pop();
  }
  writing.complete();
  return path;
}

/// "proximity_server_2026-11-27T12-00-00.123_stop.bag", by the system's clock in UTC.
std::string Recorder::fileName() const {
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  const std::time_t seconds = std::chrono::duration_cast<std::chrono::seconds>(wall).count();
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(wall).count() % 1000;
  std::tm date{};
  gmtime_r(&seconds, &date);
  char day[32], rest[16];
  std::strftime(day, sizeof day, "%Y-%m-%dT%H-%M-%S", &date);
  std::snprintf(rest, sizeof rest, ".%03d_", static_cast<int>(milliseconds));
  return prefix_ + day + rest + event_.name + ".bag";
}

/// Their names sort by their time.
void Recorder::removeOldest() const {
  std::vector<fs::path> records;
  for (const fs::directory_entry& file : fs::directory_iterator(folder_)) {
    const std::string name = file.path().filename();
    const bool is_ours = name.compare(0, prefix_.size(), prefix_) == 0 && file.path().extension() == ".bag";
    if (is_ours && name.size() > prefix_.size() && std::isdigit(static_cast<unsigned char>(name[prefix_.size()])))
      records.push_back(file.path());
  }
  std::sort(records.begin(), records.end());
  for (std::size_t i = 0; i + count_ < records.size(); ++i) fs::remove(records[i]);
}

}  // namespace proximity_server::node
