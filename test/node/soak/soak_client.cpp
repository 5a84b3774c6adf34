#include "node/soak/soak_client.h"

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "node/load/node_under_load.h"

namespace proximity_server::node {

using namespace scene;
namespace {

using Outcome = SoakRecord::Outcome;

/// [s] Between two questions, on average half of it: the machine is for the node.
constexpr double kLongestPause = 0.02;
/// [s] So much younger than an answer its stamp may be asked for again.
constexpr double kLongestMemory = 1.0;

bool isAboutTf(const QueryStatus& status) {
  return status.code <= QueryStatus::TF_UNAVAILABLE && status.code >= QueryStatus::TF_EXTRAPOLATION;
}

/// Whether an answer without success says all the same what can be checked.
template <class Response>
constexpr bool kIsMotion =
    std::is_same_v<Response, FirstContactResponse> || std::is_same_v<Response, QueryTrajectoryResponse>;

}  // namespace

SoakClient::SoakClient(const std::shared_ptr<const SceneModel>& model, const SoakObjects& objects, SoakRecord& record,
                       std::uint64_t seed)
    : model_(*model), objects_(objects), record_(record), checks_(model), generator_(seed), thread_([this] {
        run();
      }) {}

double SoakClient::waiting() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::max(0.0, std::chrono::duration<double>(Clock::now() - begin_).count());
}

std::string SoakClient::service() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return service_;
}

void SoakClient::run() {
  while (!record_.isStopped()) {
    askSomething();
    std::this_thread::sleep_for(std::chrono::duration<double>(random(0.0, kLongestPause)));
  }
}

double SoakClient::random(double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(generator_);
}

void SoakClient::askSomething() {
  switch (static_cast<int>(random(0.0, 8.0))) {
    case 0: {
      MinimumDistanceRequest request;
      choosePair(request.a, request.b);
      request.stamp = chooseStamp();
      return ask<MinimumDistanceRequest, MinimumDistanceResponse>("minimum_distance", request);
    }
    case 1: {
      SeparationAxisRequest request;
      choosePair(request.a, request.b);
      request.stamp = chooseStamp();
      request.margin = random(0.0, 0.3);
      return ask<SeparationAxisRequest, SeparationAxisResponse>("separation_axis", request);
    }
    case 2: {
      PenetrationDepthRequest request;
      choosePair(request.a, request.b);
      request.stamp = chooseStamp();
      return ask<PenetrationDepthRequest, PenetrationDepthResponse>("penetration_depth", request);
    }
    case 3:
      return ask<QueryPairsRequest, QueryPairsResponse>("query_pairs", pairs());
    case 4:
      return ask<QueryConfigurationRequest, QueryConfigurationResponse>("query_configuration", configuration());
    case 5:
      return ask<FirstContactRequest, FirstContactResponse>("time_of_contact", contact());
    case 6:
      return ask<QueryTrajectoryRequest, QueryTrajectoryResponse>("query_trajectory", trajectory());
    default: {
      std_srvs::SetBoolRequest request;
      request.data = 1;
      std_srvs::SetBoolResponse response;
      if (call("enable_monitor", request, response)) record_.count("enable_monitor", Outcome::Right);
    }
  }
}

/// A call that is lost while the node is there, and was there before, is a wrong answer.
template <class Request, class Response>
bool SoakClient::call(const std::string& service, const Request& request, Response& response) {
  ros::ServiceClient& client = clients_[service];
  if (!client.isValid()) {
    client = ros::NodeHandle().serviceClient<Request, Response>(kNodeName + "/" + service, /*persistent=*/true);
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    begin_ = Clock::now();
    service_ = service;
  }
  const int starts = record_.starts();
  const bool was_up = record_.nodeIsUp();
  Request sent = request;
  const bool answered = client.isValid() && client.call(sent, response);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    begin_ = Clock::time_point::max();
  }
  if (answered) return true;
  client = ros::ServiceClient();
  const bool excused = !was_up || !record_.nodeIsUp() || record_.starts() != starts || starts_seen_ != starts;
  starts_seen_ = starts;  // once: every connection of before is broken
  if (excused || record_.isStopped()) {
    record_.count(service, Outcome::Lost);
    for (auto& entry : clients_) entry.second = ros::ServiceClient();
  } else {
    record_.countWrong(service, "the call was lost while the node was there");
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return false;
}

template <class Request, class Response>
void SoakClient::ask(const std::string& service, const Request& request) {
  Response response;
  const Clock::time_point asked_at = Clock::now();
  if (call(service, request, response)) judge(service, request, response, asked_at);
}

/// Of the objects that the node may have used, one set must give the answer.
template <class Request, class Response>
Verdict SoakClient::verdictWith(const std::vector<SoakObjects::Set>& sets, const Request& request,
                                const Response& response) {
  Verdict verdict;
  for (const SoakObjects::Set& objects : sets) {
    checks_.use(objects);
    try {
      verdict = checks_.check(request, response);
    } catch (const std::invalid_argument& error) {
      verdict = error.what();  // an object of the answer is not in the set
    }
    if (verdict.empty()) break;
  }
  return verdict;
}

template <class Request, class Response>
void SoakClient::judge(const std::string& service, const Request& request, const Response& response,
                       Clock::time_point asked_at) {
  if (!response.success) {
    if (isAboutTf(response.status)) return record_.count(service, Outcome::Refused);
    const bool is_proven = kIsMotion<Response> && (response.status.code == QueryStatus::OVER_BUDGET ||
                                                   response.status.code == QueryStatus::NOT_CONVERGED);
    if (!is_proven) return record_.countWrong(service, "refused: " + response.status.message);
  }
  // A state that the request gives entirely does not depend on tf.
  if (!response.header.stamp.isZero() && record_.isMisled(response.header.stamp)) {
    return record_.count(service, Outcome::Misled);
  }
  const std::vector<SoakObjects::Set> sets = objects_.since(asked_at);
  if (sets.empty()) return record_.count(service, Outcome::Lost);
  const Verdict verdict = verdictWith(sets, request, response);
  if (verdict.empty()) {
    record_.count(service, Outcome::Right);
  } else {
    record_.countWrong(service, "at " + std::to_string(response.header.stamp.toSec()) + ": " + verdict);
  }
  // Asked about all pairs: then tf has a message of every joint with this stamp, and interpolates none.
  if (std::is_same_v<Request, QueryPairsRequest>) last_stamp_ = response.header.stamp;
}

sensor_msgs::JointState SoakClient::randomState() {
  sensor_msgs::JointState state;
  for (const Joint& joint : model_.robot.joints) {
    if (!isSettable(joint)) continue;
    const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
    state.name.push_back(joint.name);
    state.position.push_back(limited ? random(joint.lower, joint.upper) : random(-M_PI, M_PI));
  }
  return state;
}

/// Half of the time none, which means all.
void SoakClient::choosePair(proximity_server::ShapeRef& a, proximity_server::ShapeRef& b) {
  if (randomly(0.5)) return;
  const std::vector<int>& checked = model_.pairs.checked;
  const auto row = static_cast<std::size_t>(random(0.0, static_cast<double>(checked.size())));
  const LinkPair& pair = model_.pairs.pairs[static_cast<std::size_t>(checked[std::min(row, checked.size() - 1)])];
  a.link = model_.robot.links[static_cast<std::size_t>(pair.link_a)].name;
  b.link = model_.robot.links[static_cast<std::size_t>(pair.link_b)].name;
}

/// Mostly the latest time; else one at which tf had a message, a short while ago.
ros::Time SoakClient::chooseStamp() {
  const bool again = !last_stamp_.isZero() && ros::Time::now() - last_stamp_ < ros::Duration(kLongestMemory);
  return again && randomly(0.3) ? last_stamp_ : ros::Time();
}

QueryPairsRequest SoakClient::pairs() {
  QueryPairsRequest request;
  request.stamp = chooseStamp();
  const std::uint8_t modes[] = {QueryPairsRequest::MINIMUM, QueryPairsRequest::K_CLOSEST, QueryPairsRequest::PER_PAIR,
                                QueryPairsRequest::BELOW_THRESHOLD};
  request.mode = modes[static_cast<std::size_t>(random(0.0, 3.999))];
  if (request.mode == QueryPairsRequest::K_CLOSEST) request.k = 5;
  if (request.mode == QueryPairsRequest::BELOW_THRESHOLD) request.threshold = random(0.0, 0.3);
  return request;
}

QueryConfigurationRequest SoakClient::configuration() {
  const QueryPairsRequest asked = pairs();
  QueryConfigurationRequest request;
  request.mode = asked.mode;
  request.k = asked.k;
  request.threshold = asked.threshold;
  request.states.resize(static_cast<std::size_t>(random(1.0, 9.0)));
  for (sensor_msgs::JointState& state : request.states) state = randomState();
  return request;
}

FirstContactRequest SoakClient::contact() {
  FirstContactRequest request;
  choosePair(request.a, request.b);
  request.stamp = chooseStamp();
  request.joints = randomState();
  request.joints.position.clear();
  for (std::size_t i = 0; i < request.joints.name.size(); ++i) {
    request.joints.velocity.push_back(random(-0.5, 0.5));
  }
  request.horizon = random(0.1, 2.0);
  request.contact_distance = random(0.0, 0.05);
  return request;
}

QueryTrajectoryRequest SoakClient::trajectory() {
  QueryTrajectoryRequest request;
  choosePair(request.a, request.b);
  request.contact_distance = random(0.0, 0.05);
  for (int i = 0; i < 3; ++i) {
    const sensor_msgs::JointState state = randomState();
    trajectory_msgs::JointTrajectoryPoint point;
    point.positions = state.position;
    point.time_from_start = ros::Duration(i);
    request.trajectory.joint_names = state.name;
    request.trajectory.points.push_back(point);
  }
  return request;
}

}  // namespace proximity_server::node
