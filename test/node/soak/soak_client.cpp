#include "node/soak/soak_client.h"

#include "node/load/node_under_load.h"

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

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
                       unsigned seed)
    : model_(*model),
      objects_(objects),
      record_(record),
      checks_(model),
      chance_(seed),
      calls_(record),
      thread_([this] { run(); }) {}

void SoakClient::run() {
  while (!record_.isStopped()) {
    askSomething();
    std::this_thread::sleep_for(std::chrono::duration<double>(chance_.between(0.0, kLongestPause)));
  }
}

/// Asks about one checked pair of links, or half of the time about all that are checked.
template <class Request>
Request SoakClient::aboutAPair() {
  Request request;
  if (chance_.happens(0.5)) {
    const LinkPair& pair = model_.pairs.pairs[chance_.oneOf(model_.pairs.checked)];
    request.a.link = model_.robot.links[pair.link_a].name;
    request.b.link = model_.robot.links[pair.link_b].name;
  }
  if constexpr (!std::is_same_v<Request, QueryTrajectoryRequest>) request.stamp = chooseStamp();
  return request;
}

/// Mostly the latest time; else one at which tf had a message, a short while ago.
ros::Time SoakClient::chooseStamp() {
  const bool again = !last_stamp_.isZero() && ros::Time::now() - last_stamp_ < ros::Duration(kLongestMemory);
  return again && chance_.happens(0.3) ? last_stamp_ : ros::Time();
}

void SoakClient::askSomething() {
  switch (chance_.below(8)) {
    case 0:
      return ask<MinimumDistanceRequest, MinimumDistanceResponse>("minimum_distance",
                                                                  aboutAPair<MinimumDistanceRequest>());
    case 1: {
      SeparationAxisRequest request = aboutAPair<SeparationAxisRequest>();
      request.margin = chance_.between(0.0, 0.3);
      return ask<SeparationAxisRequest, SeparationAxisResponse>("separation_axis", request);
    }
    case 2:
      return ask<PenetrationDepthRequest, PenetrationDepthResponse>("penetration_depth",
                                                                    aboutAPair<PenetrationDepthRequest>());
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
      if (calls_.call("enable_monitor", request, response)) record_.count("enable_monitor", Outcome::Right);
    }
  }
}

template <class Request, class Response>
void SoakClient::ask(const std::string& service, const Request& request) {
  Response response;
  const Clock::time_point asked_at = Clock::now();
  if (calls_.call(service, request, response)) return judge(service, request, response, asked_at);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

/// One of the sets of objects that the node may have used must give the answer.
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
    state.position.push_back(limited ? chance_.between(joint.lower, joint.upper) : chance_.between(-M_PI, M_PI));
  }
  return state;
}

QueryPairsRequest SoakClient::pairs() {
  QueryPairsRequest request;
  request.stamp = chooseStamp();
  const std::uint8_t modes[] = {QueryPairsRequest::MINIMUM, QueryPairsRequest::K_CLOSEST, QueryPairsRequest::PER_PAIR,
                                QueryPairsRequest::BELOW_THRESHOLD};
  request.mode = chance_.oneOf(modes);
  if (request.mode == QueryPairsRequest::K_CLOSEST) request.k = 5;
  if (request.mode == QueryPairsRequest::BELOW_THRESHOLD) request.threshold = chance_.between(0.0, 0.3);
  return request;
}

QueryConfigurationRequest SoakClient::configuration() {
  const QueryPairsRequest asked = pairs();
  QueryConfigurationRequest request;
  request.mode = asked.mode;
  request.k = asked.k;
  request.threshold = asked.threshold;
  request.states.resize(1 + chance_.below(8));
  for (sensor_msgs::JointState& state : request.states) state = randomState();
  return request;
}

FirstContactRequest SoakClient::contact() {
  auto request = aboutAPair<FirstContactRequest>();
  request.joints = randomState();
  request.joints.position.clear();
  for (std::size_t i = 0; i < request.joints.name.size(); ++i) {
    request.joints.velocity.push_back(chance_.between(-0.5, 0.5));
  }
  request.horizon = chance_.between(0.1, 2.0);
  request.contact_distance = chance_.between(0.0, 0.05);
  return request;
}

QueryTrajectoryRequest SoakClient::trajectory() {
  auto request = aboutAPair<QueryTrajectoryRequest>();
  request.contact_distance = chance_.between(0.0, 0.05);
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
