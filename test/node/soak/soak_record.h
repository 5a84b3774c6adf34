#pragma once

#include <ros/time.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace proximity_server::node {

/// What happened to one kind of question, or of fault.
struct ServiceTally {
  std::uint64_t right = 0;    ///< checked, and as it should be
  std::uint64_t refused = 0;  ///< tf did not allow an answer, and the status says so
  std::uint64_t misled = 0;   ///< tf itself was wrong then: only sound
  std::uint64_t lost = 0;     ///< while the node was down
  std::uint64_t wrong = 0;
};
struct FaultTally {
  std::uint64_t count = 0;
  std::uint64_t survived = 0;     ///< the right answers were back in time
  double slowest_recovery = 0.0;  ///< [s]
};

/// What a long run has seen. Thread-safe.
class SoakRecord {
 public:
  enum class Outcome : unsigned char { Right, Refused, Misled, Lost };
  void count(const std::string& service, Outcome outcome);
  void countWrong(const std::string& service, const std::string& why);
  void countFault(const std::string& kind, bool survived, double recovery);

  std::map<std::string, ServiceTally> services() const;
  std::map<std::string, FaultTally> faults() const;

  // Times at which what tf says is not where the robot is.
  void startMisleading();
  void stopMisleading();
  bool isMisled(const ros::Time& stamp) const;

  // Whether the node is there, and how often it was started anew.
  void nodeGoesDown() { node_is_up_ = false; }
  void nodeIsBack() {
    ++starts_;
    node_is_up_ = true;
  }
  bool nodeIsUp() const { return node_is_up_; }
  int starts() const { return starts_; }

  // The end.
  void stop() { stop_ = true; }
  bool isStopped() const { return stop_; }

 private:
  struct Interval {
    ros::Time begin, end;
  };

  mutable std::mutex mutex_;
  std::map<std::string, ServiceTally> services_;
  std::map<std::string, FaultTally> faults_;
  std::vector<Interval> misleading_;
  std::atomic<bool> node_is_up_{true};
  std::atomic<int> starts_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace proximity_server::node
