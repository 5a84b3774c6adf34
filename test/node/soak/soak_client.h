#pragma once

#include <ros/service_client.h>

#include <atomic>
#include <chrono>
#include <map>
#include <random>
#include <string>
#include <thread>

#include "node/soak/answer_checks.h"
#include "node/soak/soak_objects.h"
#include "node/soak/soak_record.h"

namespace proximity_server::node {

using namespace scene;

/// A client that asks all services at random, one question after the other, and checks every answer.
class SoakClient {
 public:
  /// Everything must outlive this.
  SoakClient(const std::shared_ptr<const SceneModel>& model, const SoakObjects& objects, SoakRecord& record,
             std::uint64_t seed);
  /// When the record is stopped. A call that hangs hangs here too.
  ~SoakClient() { thread_.join(); }

  /// [s] that the call which is under way has taken so far, and of which service it is.
  double waiting() const;
  std::string service() const;

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  void askSomething();

  template <class Request, class Response>
  void ask(const std::string& service, const Request& request);
  template <class Request, class Response>
  bool call(const std::string& service, const Request& request, Response& response);
  template <class Request, class Response>
  void judge(const std::string& service, const Request& request, const Response& response, Clock::time_point asked_at);
  template <class Request, class Response>
  Verdict verdictWith(const std::vector<SoakObjects::Set>& sets, const Request& request, const Response& response);

  double random(double from, double to);
  bool randomly(double share) { return random(0.0, 1.0) < share; }
  sensor_msgs::JointState randomState();
  void choosePair(proximity_server::ShapeRef& a, proximity_server::ShapeRef& b);
  ros::Time chooseStamp();
  QueryPairsRequest pairs();
  QueryConfigurationRequest configuration();
  FirstContactRequest contact();
  QueryTrajectoryRequest trajectory();

  const SceneModel& model_;
  const SoakObjects& objects_;
  SoakRecord& record_;
  AnswerChecks checks_;
  std::mt19937_64 generator_;
  std::map<std::string, ros::ServiceClient> clients_;
  int starts_seen_ = 0;  // of the node, at the last answer
  ros::Time last_stamp_;
  mutable std::mutex mutex_;  // guards the call that is under way
  Clock::time_point begin_ = Clock::time_point::max();
  std::string service_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace proximity_server::node
