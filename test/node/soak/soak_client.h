#pragma once

#include "chance.h"
#include "node/soak/answer_checks.h"
#include "node/soak/soak_objects.h"
#include "node/soak/soak_record.h"

#include <chrono>
#include <string>
#include <thread>

namespace proximity_server::node {

using namespace scene;

/// A client that asks all services at random, one question after the other, and checks every answer.
class SoakClient {
 public:
  /// Everything must outlive this.
  SoakClient(const std::shared_ptr<const SceneModel>& model, const SoakObjects& objects, SoakRecord& record,
             unsigned seed);
  /// Ends when the record is stopped. A call that hangs hangs here too.
  ~SoakClient() { thread_.join(); }

  const SoakCalls& calls() const { return calls_; }

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  void askSomething();

  template <class Request, class Response>
  void ask(const std::string& service, const Request& request);
  template <class Request, class Response>
  void judge(const std::string& service, const Request& request, const Response& response, Clock::time_point asked_at);
  template <class Request, class Response>
  Verdict verdictWith(const std::vector<SoakObjects::Set>& sets, const Request& request, const Response& response);

  sensor_msgs::JointState randomState();
  ros::Time chooseStamp();
  template <class Request>
  Request aboutAPair();
  QueryPairsRequest pairs();
  QueryConfigurationRequest configuration();
  FirstContactRequest contact();
  QueryTrajectoryRequest trajectory();

  const SceneModel& model_;
  const SoakObjects& objects_;
  SoakRecord& record_;
  AnswerChecks checks_;
  Chance chance_;
  SoakCalls calls_;
  ros::Time last_stamp_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace proximity_server::node
