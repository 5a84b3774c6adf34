#pragma once

#include "node/robot/robot.h"
#include "proximity_server/QueryStatus.h"

#include <ros/time.h>

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The latest cloud of a sensed source, with the numbers of its points.
struct SensedCloud {
  std::string source;              ///< its name
  double age = 0.0;                ///< [s] 0 if there is no cloud
  std::uint64_t points = 0;        ///< with a finite place
  std::uint64_t out_of_range = 0;  ///< left out, see Sensing::range
  std::uint64_t over_limit = 0;    ///< left out, see Sensing::max_points
  std::uint64_t on_robot = 0;      ///< left out, see Sensing::self_padding
  std::uint64_t voxels = 0;        ///< of all others, and those that persist
  std::uint64_t persistent = 0;    ///< voxels of clouds before it
  std::uint64_t boxes = 0;         ///< of these voxels
  double seconds = 0.0;            ///< of wall time, from the transforms to the boxes
};

/// How old the latest messages of tracked and sensed sources are, in ROS time. Thread-safe.
class TrackedAges {
 public:
  /// The sources of a robot. The messages of before count no more if the sources or the reference frame have changed.
  void follow(const Robot& robot);

  /// Returns why a message with this stamp is not to be used ("it is 2.5 s old"), or "" if it is. A source whose latest
  /// message is far ahead of the clock begins anew: the clock has jumped back.
  std::string refusalOf(const std::string& name, const ros::Time& stamp, const ros::Time& now);

  /// A message was used; of a sensed source it was this cloud.
  void accept(const std::string& name, const ros::Time& stamp, const SensedCloud& cloud = {});

  /// Why the latest message was not used. Without a message before it that is still good (`is_stale`), the source is
  /// stale at once.
  void refuse(const std::string& name, const std::string& reason, bool is_stale);

  /// OK, or TF_STALE with the first source that is stale, its topic and how old it is.
  QueryStatus status(const ros::Time& now) const;

  /// [s] The ages of the latest messages that count, in the order of Config::tracked; nullopt: there is none.
  std::vector<std::optional<double>> all(const ros::Time& now) const;

  /// The latest cloud of each sensed source; without points if there is none that counts.
  std::vector<SensedCloud> clouds(const ros::Time& now) const;

 private:
  struct Entry {
    TrackedSource source;
    std::optional<ros::Time> latest;  ///< the stamp of the latest message that counts
    std::string problem;              ///< why a later one was not used
    SensedCloud cloud{};              ///< of the latest message
  };
  Entry* find(const std::string& name);

  mutable std::mutex mutex_;  // guards the members below
  std::vector<Entry> entries_;
  std::string reference_frame_;
};

}  // namespace proximity_server::node
