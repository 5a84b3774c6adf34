#pragma once

#include "node/load/node_under_load.h"
#include "stress/campaign.h"

#include <ros/service_client.h>
#include <ros/time.h>

#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace proximity_server::node {

/// Counts what a long run has seen. Thread-safe.
class SoakRecord {
 public:
  using Tallies = std::map<std::string, stress::Tally>;

  /// The answer to a question was right; refused, because tf did not say where the robot was; given while tf was made
  /// to lie; or lost, because the node was killed.
  enum class Outcome : unsigned char { Right, Refused, Misled, Lost };
  void count(const std::string& service, Outcome outcome);
  void countWrong(const std::string& service, const std::string& why);
  void countFault(const std::string& kind, bool survived, double recovery);

  /// By service: right, refused, misled, lost, wrong.
  Tallies answers() const;
  /// By kind: happened, survived, recovery: the slowest one [s].
  Tallies faults() const;

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
  Tallies answers_, faults_;
  std::vector<Interval> misleading_;
  std::atomic<bool> node_is_up_{true};
  std::atomic<int> starts_{0};
  std::atomic<bool> stop_{false};
};

/// Calls services of the node, by one connection each. A call that is lost while the node is there, and was there
/// before, is a wrong answer. One thread calls; others may ask for the call that is under way.
class SoakCalls {
 public:
  explicit SoakCalls(SoakRecord& record) : record_(record) {}

  /// Returns whether the node has answered.
  template <class Request, class Response>
  bool call(const std::string& service, Request request, Response& response) {
    ros::ServiceClient& client = clients_[service];
    if (!client.isValid())
      client = ros::NodeHandle().serviceClient<Request, Response>(kNodeName + "/" + service, /*persistent=*/true);
    const int starts = record_.starts();
    const bool was_up = record_.nodeIsUp();
    begin(service);
    const bool answered = client.isValid() && client.call(request, response);
    end();
    if (!answered) countLost(service, was_up, starts);
    return answered;
  }

  void disconnect() { clients_.clear(); }

  /// The service that is called now, or was last.
  std::string service() const;
  /// [s] The time that the call which is under way has taken so far.
  double waiting() const;

 private:
  using Clock = std::chrono::steady_clock;
  void begin(const std::string& service);
  void end();
  void countLost(const std::string& service, bool was_up, int starts);

  SoakRecord& record_;
  std::map<std::string, ros::ServiceClient> clients_;
  int starts_seen_ = 0;       // of the node, at the last call that was lost
  mutable std::mutex mutex_;  // guards the call that is under way
  Clock::time_point begin_ = Clock::time_point::max();
  std::string service_;
};

}  // namespace proximity_server::node
