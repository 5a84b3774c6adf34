#pragma once

#include "node/objects/object_store.h"
#include "node/record/record_messages.h"
#include "node/record/record_ring.h"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace proximity_server::node {

/// Keeps the last seconds of the monitor, and writes them into a bag when something happens.
///
/// 1. Each cycle appends its input and its answer to a ring: settings, poses, and the serialised Clearance. That copies
///    a few kilobytes. Robots and objects are not copied: they are immutable and shared, and found by the revision.
/// 2. While the recorder waits, a new entry replaces the oldest ones. An event (another level, or the service) makes it
///    save: from then on the cycle only appends, and the writing thread only takes. So neither waits for the other. If
///    the disk is so slow that the ring is full, entries are lost and counted.
/// 3. The writing thread takes the entries from `record_seconds` before the event until kSecondsAfter behind it, makes
///    messages of them, and writes a BagFile. This gets its name when it is complete; then the oldest records above
///    `record_count` are removed.
/// 4. Each failure is a text for the diagnostics.
class Recorder {
 public:
  /// [s] A record ends so long after its event. Events until then belong to it.
  static constexpr double kSecondsAfter = 2.0;

  /// For the node with this name, "/proximity_server".
  /// Failure: throws std::invalid_argument if no file can be made in Config::record_directory, however much room there
  ///          is. That of ROS is made with the first record.
  Recorder(const Config& config, std::string node);
  ~Recorder() { stop(); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Tells the objects of a revision, and the robot that has them. To be called with every change, and after a reload.
  void know(const ObjectStore::CurrentObjects& objects);

  /// Appends a cycle. Allocates nothing, and never waits.
  void add(const Robot& robot, const PoseSnapshot& snapshot, const FrameSnapshot& frames, const Clearance& clearance,
           const MonitorSettings& settings);

  /// Begins a record with the event "service". The caller ensures that no add() runs. Returns false if nothing is kept.
  bool beginSaving();

  struct Outcome {
    std::string file;        ///< the latest record; "" if there is none
    std::string problem;     ///< why the latest attempt has failed; "" if it has not
    std::uint64_t lost = 0;  ///< cycles that are in no record because the disk was too slow
  };
  Outcome outcome() const;

  /// Ends the record that is being written. Later events write none.
  void stop();

  /// Waits until the record that is being written has ended.
  Outcome await();

 private:
  using Time = double;  ///< [s] of the steady clock
  struct Event {
    std::string name;
    Time at = 0.0;
    ros::Time stamp;
  };
  /// Before a pose of each body and frame, and the Clearance.
  struct Head {
    Time at;
    std::uint32_t sec, nsec;
    const Robot* robot;
    std::size_t bodies, frames;
    MonitorSettings settings;
  };
  struct Entry {
    Head head;
    RecordedCycle cycle;
  };
  class Writing;

  void save(const char* event, const ros::Time& stamp);
  std::uint8_t* reserve(std::size_t bytes);
  static Entry entryOf(const RecordRing::Entry& bytes);
  std::optional<ObjectStore::CurrentObjects> find(const Head& head, std::uint64_t revision) const;
  void forget();
  void run();
  std::string write();
  std::string fileName() const;
  void removeOldest() const;
  bool isEnding() const;

  const std::string node_, folder_, prefix_;
  const bool has_default_folder_;  ///< it is made if it does not exist
  const double seconds_;
  const std::size_t count_;
  const bool on_stop_, on_collision_, on_invalid_;
  RecordRing ring_;
  std::optional<std::uint8_t> level_;  ///< of the latest cycle
  Event event_;                        ///< written before is_saving_ becomes true, read by the writing thread only then
  std::atomic<bool> is_saving_{false};
  std::atomic<std::uint64_t> lost_{0};

  mutable std::mutex mutex_;  // guards the members below; add() does not take it
  std::condition_variable ended_;
  struct Known {
    ObjectStore::CurrentObjects objects;
    Time at;
  };
  std::deque<Known> known_;  ///< from the oldest that an entry may need to the present one
  Outcome outcome_;
  std::uint64_t records_ = 0;  ///< that have ended, also by a failure
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace proximity_server::node
