#include "node/services/queries.h"

#include "node/answers.h"
#include "node/asked_robot.h"

#include <proximity_server/FirstContact.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/PenetrationDepth.h>
#include <proximity_server/ProveJointBox.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/QueryPoints.h>
#include <proximity_server/QueryRays.h>
#include <proximity_server/QueryTrajectory.h>
#include <proximity_server/SeparationAxis.h>

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <cstdint>
#include <thread>
#include <type_traits>
#include <vector>

// What holds for each service that asks about the poses of tf.

namespace proximity_server::node::service_laws_test {

template <class Request>
Request asking() {
  return {};
}
template <>
QueryPairsRequest asking() {
  QueryPairsRequest request;
  request.mode = QueryPairsRequest::PER_PAIR;
  return request;
}
template <>
QueryConfigurationRequest asking() {
  QueryConfigurationRequest request;
  request.states.resize(1);
  return request;
}
template <>
QueryPointsRequest asking() {
  QueryPointsRequest request;
  request.points.resize(1);
  request.points[0].z = 3.0;
  return request;
}
template <>
QueryRaysRequest asking() {
  QueryRaysRequest request;
  request.origins.resize(1);
  request.origins[0].x = -3.0;
  request.directions.resize(1);
  request.directions[0].x = 1.0;
  return request;
}
template <>
FirstContactRequest asking() {
  FirstContactRequest request;
  request.joints.name = {"x_axis"};
  request.joints.velocity = {-0.5};
  request.horizon = 2.0;
  return request;
}
template <>
QueryTrajectoryRequest asking() {
  QueryTrajectoryRequest request;
  request.trajectory.joint_names = {"x_axis"};
  request.trajectory.points.resize(2);
  request.trajectory.points[0].positions = {0.5};
  request.trajectory.points[1].positions = {0.0};
  request.trajectory.points[1].time_from_start = ros::Duration(1.0);
  return request;
}
template <>
ProveJointBoxRequest asking() {
  ProveJointBoxRequest request;
  request.box.resize(1);
  request.box[0].name = "x_axis";
  request.box[0].lower = 0.4;
  request.box[0].upper = 0.6;
  return request;
}

template <class Request>
Request askingAt(const ros::Time& stamp) {
  Request request = asking<Request>();
  if constexpr (std::is_same_v<Request, QueryPointsRequest> || std::is_same_v<Request, QueryRaysRequest>)
    request.header.stamp = stamp;
  else
    request.stamp = stamp;
  return request;
}

/// How pairs were settled depends on the poses that a thread has asked about before.
template <class Answer>
void forgetCosts(Answer& answer) {
  answer.pairs_at_rest = answer.pairs_by_motion = answer.pairs_by_bounds = answer.pairs_computed = 0;
}

template <class Request>
class ServiceLaws : public AskedGantry {};

using Requests = testing::Types<MinimumDistanceRequest, SeparationAxisRequest, PenetrationDepthRequest,
                                QueryPairsRequest, QueryConfigurationRequest, QueryPointsRequest, QueryRaysRequest,
                                FirstContactRequest, QueryTrajectoryRequest, ProveJointBoxRequest>;
TYPED_TEST_SUITE(ServiceLaws, Requests);

TYPED_TEST(ServiceLaws, WithoutTfNothingIsSaid) {
  const auto response = this->ask(asking<TypeParam>());
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_NE(response.status.message.find("joint '"), std::string::npos) << response.status.message;
}

TYPED_TEST(ServiceLaws, AJointThatTfDoesNotKnowIsNamed) {
  this->gantry_.moveTo({Gantry::slide({0.5, 0.0, 0.0}), Gantry::ball({0.5, 0.0, 0.0})});
  EXPECT_NE(this->ask(asking<TypeParam>()).status.message.find("'lift'"), std::string::npos);
}

TYPED_TEST(ServiceLaws, AStampOutsideOfWhatTfHoldsIsRefused) {
  const ros::Time stamp = this->moveTo({0.5, 0.0, 0.0});
  for (const ros::Time& other :
       {stamp - ros::Duration(500.0), stamp + ros::Duration(500.0), ros::TIME_MIN, ros::TIME_MAX})
    expectRefusal(this->ask(askingAt<TypeParam>(other)), QueryStatus::TF_EXTRAPOLATION, "joint '");
}

TYPED_TEST(ServiceLaws, TheAnswerIsTheSameInEveryThread) {
  const auto request = askingAt<TypeParam>(this->moveTo({0.5, 0.0, 0.0}));
  const auto bytes = [&] {
    auto response = this->ask(request);
    EXPECT_TRUE(response.success) << response.status.message;
    if constexpr (std::is_same_v<TypeParam, QueryPairsRequest>) forgetCosts(response);
    if constexpr (std::is_same_v<TypeParam, QueryConfigurationRequest>) forgetCosts(response.states.at(0));
    const std::uint32_t length = ros::serialization::serializationLength(response);
    std::vector<std::uint8_t> serialized(length);
    ros::serialization::OStream stream(serialized.data(), length);
    ros::serialization::serialize(stream, response);
    return serialized;
  };
  const std::vector<std::uint8_t> expected = bytes();
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (int n = 0; n < 20; ++n) EXPECT_EQ(bytes(), expected);
    });
  for (std::thread& thread : threads) thread.join();
}

template <class Request>
class HastyService : public testing::Test {};
TYPED_TEST_SUITE(HastyService, Requests);

TYPED_TEST(HastyService, SaysWhenItsTimeIsOver) {
  if (std::is_same_v<TypeParam, PenetrationDepthRequest>) GTEST_SKIP() << "bounds tell that nothing overlaps";
  Config config;
  config.max_request_time = 1e-9;
  AskedRobot gantry({robotText("gantry.urdf"), robotText("gantry.srdf")}, config);
  const auto response = gantry.ask(askingAt<TypeParam>(gantry.moveTo(Gantry::all({0.5, 0.0, 0.0}))));
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.status.code, QueryStatus::OVER_BUDGET) << response.status.message;
}

}  // namespace proximity_server::node::service_laws_test
