#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include <proximity_server/FirstContact.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/QueryTrajectory.h>
#include "node/answers.h"
#include "node/gantry.h"
#include "node/object_messages.h"

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

// Many requests at once, long ones among them, and what is too much.

namespace proximity_server::node::load_test {

const std::string kNode = "/proximity_server/";
const std::string kHasty = "/hasty/";
constexpr std::size_t kMaxBatch = 20000;
constexpr double kRate = 50.0;  // [Hz] of the monitor

Gantry& gantry() { return connectedGantry(2); }

MinimumDistanceRequest baseAndBall(const ros::Time& stamp = {}) {
  MinimumDistanceRequest request;
  request.a = shape("base");
  request.b = shape("ball");
  request.stamp = stamp;
  return request;
}

/// A list of one pair, many times.
QueryPairsRequest batchOf(std::size_t pairs) {
  QueryPairsRequest request;
  request.a.assign(pairs, shape("base"));
  request.b.assign(pairs, shape("ball"));
  request.mode = QueryPairsRequest::PER_PAIR;
  return request;
}

/// Threads that call until they are told to stop, or once.
class Callers {
 public:
  template <class Call>
  Callers(int count, Call call) {
    for (int i = 0; i < count; ++i) {
      threads_.emplace_back([this, call] {
        do {
          call();
          ++answers_;
        } while (!stop_);
      });
    }
  }
  ~Callers() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

  void onlyOnce() { stop_ = true; }
  int answers() const { return answers_; }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<int> answers_{0};
  std::vector<std::thread> threads_;
};

class Load : public testing::Test {
 protected:
  void SetUp() override {
    gantry().hold({0.5, 0.0, 0.0});
    ASSERT_TRUE(inbox_.next([](const Clearance& message) { return message.level != Clearance::INVALID; }));
  }
  void TearDown() override { gantry().release(); }

  static void expectAnswers(int calls) {
    for (int n = 0; n < calls; ++n) {
      const auto response = call<MinimumDistanceResponse>(kNode + "minimum_distance", baseAndBall());
      ASSERT_TRUE(response.success) << response.status.message;
      EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
    }
  }

  /// For two seconds the monitor publishes valid messages, at least half as many as it should on an idle machine.
  void expectMonitorRuns() {
    constexpr double kWatched = 2.0;  // [s]
    inbox_.clear();
    const ros::Time end = ros::Time::now() + ros::Duration(kWatched);
    int cycles = 0;
    for (; ros::Time::now() < end; ++cycles) {
      const auto message = inbox_.next();
      ASSERT_TRUE(message);
      EXPECT_NE(message->level, Clearance::INVALID) << message->status.message;
    }
    EXPECT_GE(cycles, 0.5 * kWatched * kRate);
  }

  Inbox<Clearance> inbox_{ros::NodeHandle(), kNode + "clearance"};
};

// Regression: four threads answered all requests, so that four that waited for tf held up everybody else.
TEST_F(Load, RequestsThatWaitForTfDelayNoOther) {
  constexpr int kWaiting = 20;
  const ros::Time not_yet = ros::Time::now() + ros::Duration(1000.0);
  Callers waiting(kWaiting, [&] {
    const auto response = call<MinimumDistanceResponse>(kNode + "minimum_distance", baseAndBall(not_yet));
    EXPECT_EQ(response.status.code, QueryStatus::TF_EXTRAPOLATION) << response.status.message;
  });
  waiting.onlyOnce();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // until all of them wait
  expectAnswers(100);
  EXPECT_EQ(waiting.answers(), 0);  // tf_timeout is 3 s
  expectMonitorRuns();
}

TEST_F(Load, HugeRequestsDelayNeitherOthersNorTheMonitor) {
  const QueryPairsRequest huge = batchOf(kMaxBatch);
  std::atomic<int> under_way{0};
  Callers callers(8, [&] {
    ++under_way;
    const auto response = call<QueryPairsResponse>(kNode + "query_pairs", huge);
    EXPECT_TRUE(response.success) << response.status.message;
    EXPECT_EQ(response.pairs.size(), kMaxBatch);
  });
  expectMonitorRuns();
  expectAnswers(100);
  EXPECT_GE(under_way, 8);
}

TEST_F(Load, TooManyPairsAreRefusedByTheirField) {
  const auto response = call<QueryPairsResponse>(kNode + "query_pairs", batchOf(kMaxBatch + 1));
  expectRefusal(response, QueryStatus::OVER_BUDGET, "a: 20001 entries, max_batch is 20000");
}

// Regression: each of the empty names stands for every pair, and all of them were listed before they were counted.
TEST_F(Load, NamesThatStandForManyPairsAreCountedAsSuch) {
  QueryPairsRequest request;
  request.a.resize(kMaxBatch);
  const auto response = call<QueryPairsResponse>(kNode + "query_pairs", request);
  expectRefusal(response, QueryStatus::OVER_BUDGET, "a: 20002 pairs in its first 10001 entries");
}

TEST_F(Load, TooManyStatesAreRefusedByTheirField) {
  QueryConfigurationRequest request;
  request.states.resize(kMaxBatch + 1);
  const auto response = call<QueryConfigurationResponse>(kNode + "query_configuration", request);
  expectRefusal(response, QueryStatus::OVER_BUDGET,
                "states: 20001 returned pairs (up to 1 in each of 20001 states), max_batch is 20000");
}

TEST_F(Load, TooManyPointsOfATrajectoryAreRefusedByTheirField) {
  QueryTrajectoryRequest request;
  request.trajectory.joint_names = {"x_axis"};
  request.trajectory.points.resize(kMaxBatch + 1);
  const auto response = call<QueryTrajectoryResponse>(kNode + "query_trajectory", request);
  expectRefusal(response, QueryStatus::OVER_BUDGET, "trajectory: 20001 points, max_batch is 20000");
}

TEST_F(Load, ATimeBudgetBeyondTheLimitIsRefused) {
  FirstContactRequest request;
  request.horizon = 1.0;
  request.joints.name = {"x_axis"};
  request.joints.velocity = {-1.0};
  request.time_budget = ros::Duration(21.0);
  const auto response = call<FirstContactResponse>(kNode + "time_of_contact", request);
  expectRefusal(response, QueryStatus::OVER_BUDGET, "time_budget is 21 s, max_request_time is 20 s");
}

// ---- objects

/// A ball at (0.5, y, 0), so that the ball of the robot is y - 0.2 m from it.
ObjectChange addPart(double y) {
  ObjectChange part = addBall("part", poseAt(0.5, y, 0.0));
  part.operation = ObjectChange::REPLACE;
  return part;
}

ApplyObjectsResponse apply(const std::vector<ObjectChange>& changes) {
  return proximity_server::node::call<ApplyObjectsResponse>(kNode + "apply_objects", requestOf(changes));
}

class ObjectLoad : public Load {
 protected:
  void SetUp() override {
    Load::SetUp();
    topic_ = ros::NodeHandle().advertise<ObjectChanges>(kNode + "apply_objects", 100000);
    ASSERT_TRUE(holdsWithin(kPatience, [&] { return topic_.getNumSubscribers() > 0; }));
  }
  void TearDown() override {
    EXPECT_TRUE(apply({change(ObjectChange::REMOVE, "*")}).success);
    Load::TearDown();
  }

  double distanceOfPart() {
    const auto request = between<MinimumDistanceRequest>("ball", "part");
    return call<MinimumDistanceResponse>(kNode + "minimum_distance", request).pair.distance;
  }

  ros::Publisher topic_;
};

// Regression: the topic was served by the threads of the requests. Where two of them had a message of it at a time, one
// message stayed in the queue, or a request of apply_objects, for which then no thread came.
TEST_F(ObjectLoad, AStreamOfChangesIsAppliedToItsEndAndDelaysNoCallOfTheService) {
  for (int burst = 0; burst < 20; ++burst) {
    const double last_y = 1.0 + 0.1 * burst;
    for (int i = 0; i < 200; ++i) topic_.publish(messageOf({addPart(5.0 + 0.01 * i)}));
    topic_.publish(messageOf({addPart(last_y)}));
    EXPECT_TRUE(apply({}).success);
    EXPECT_TRUE(holdsWithin(kPatience, [&] { return std::abs(distanceOfPart() - (last_y - 0.2)) < kTolerance; }))
        << "burst " << burst << ": " << distanceOfPart();
  }
}

TEST_F(ObjectLoad, AThousandChangesASecondLeaveTheMonitorItsCycles) {
  ASSERT_TRUE(apply({addPart(1.0)}).success);
  std::atomic<bool> ends{false};
  std::thread changes([&] {
    ros::Rate rate(1000.0);
    for (int i = 0; !ends; ++i) {
      const bool is_wrong = i % 10 == 0;
      topic_.publish(messageOf({is_wrong ? change(ObjectChange::MOVE, "missing") : addPart(1.0 + 0.001 * (i % 1000))}));
      rate.sleep();
    }
  });
  expectMonitorRuns();
  expectAnswers(100);
  ends = true;
  changes.join();
}

// Regression: changes, which are applied one after the other, took all threads of the long requests while they waited.
TEST_F(ObjectLoad, ChangesThatWaitForTfDelayNoRequest) {
  ObjectChange unplaced = addPart(1.0);
  unplaced.header.frame_id = "not_there";
  constexpr int kWaiting = 70;  // more than a queue of requests has threads
  Callers waiting(kWaiting, [&] { apply({unplaced}); });
  waiting.onlyOnce();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // until all of them wait
  for (int n = 0; n < 10; ++n)
    EXPECT_TRUE(call<QueryPairsResponse>(kNode + "query_pairs", QueryPairsRequest()).success);
  EXPECT_LE(waiting.answers(), kWaiting / 2) << "each waits for tf_timeout, 3 s";
  geometry_msgs::TransformStamped frame;
  frame.header.frame_id = "base";
  frame.child_frame_id = unplaced.header.frame_id;
  frame.transform.rotation.w = 1.0;
  EXPECT_TRUE(holdsWithin(kPatience, [&] {
    gantry().publish(frame, ros::Time::now());
    return waiting.answers() == kWaiting;
  }));
}

TEST_F(ObjectLoad, AMeshOfAMillionTrianglesIsRefusedByItsName) {
  ObjectChange add = change(ObjectChange::ADD, "scan");
  add.meshes.resize(1);
  add.meshes[0].vertices.resize(3);
  add.meshes[0].triangles.resize(1000000);
  const ApplyObjectsResponse response = apply({add});
  expectRefusal(response, QueryStatus::INVALID_ARGUMENT,
                "object \"scan\": shape 1: the mesh has more than 200000 triangles");
  for (int i = 0; i < 10; ++i) topic_.publish(messageOf({add}));
  expectMonitorRuns();
}

TEST_F(ObjectLoad, AMapOfAHundredThousandBoxesIsOneObject) {
  ObjectChange map = change(ObjectChange::ADD, "map");
  map.boxes.resize(1);
  map.boxes[0].sizes.resize(1);
  map.boxes[0].sizes[0].x = map.boxes[0].sizes[0].y = map.boxes[0].sizes[0].z = 0.1;
  for (int i = 0; i < 100000; ++i) {
    const int column = i % 100, row = i / 100 % 100, layer = i / 10000;
    geometry_msgs::Point& centre = map.boxes[0].centres.emplace_back();
    centre.x = 0.1 * column;
    centre.y = 1.0 + 0.1 * row;
    centre.z = 0.1 * layer;
  }
  const ApplyObjectsResponse response = apply({map});
  ASSERT_TRUE(response.success) << response.status.message;
  MinimumDistanceRequest request;
  request.a = shape("ball");
  request.b = shape("map");
  // The ball of radius 0.1 m at (0.5, 0, 0), and the first row of boxes, from y = 0.95 m on.
  EXPECT_NEAR(call<MinimumDistanceResponse>(kNode + "minimum_distance", request).pair.distance, 0.85, kTolerance);
  expectMonitorRuns();
}

// ---- the time of a request

TEST(HastyNode, LeavesPairsWithoutAnAnswerUnknown) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  QueryPairsRequest request = batchOf(3);
  request.stamp = stamp;
  const auto response = call<QueryPairsResponse>(kHasty + "query_pairs", request);
  expectRefusal(response, QueryStatus::OVER_BUDGET, "3 of 3 pairs have no answer, max_request_time is 1e-06 s");
  EXPECT_EQ(response.pairs_unknown, 3u);
  ASSERT_EQ(response.pairs.size(), 3u);
  for (const Proximity& pair : response.pairs) EXPECT_TRUE(saysNothing(pair));
  EXPECT_TRUE(saysNothing(response.minimum));
}

TEST(HastyNode, HasNoMinimumOfPairsThatItDidNotLookAt) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  for (const std::uint8_t mode : {QueryPairsRequest::MINIMUM, QueryPairsRequest::FIRST, QueryPairsRequest::K_CLOSEST,
                                  QueryPairsRequest::BELOW_THRESHOLD}) {
    QueryPairsRequest request;
    request.stamp = stamp;
    request.mode = mode;
    request.threshold = 10.0;
    const auto response = call<QueryPairsResponse>(kHasty + "query_pairs", request);
    expectRefusal(response, QueryStatus::OVER_BUDGET, "max_request_time");
    EXPECT_TRUE(response.pairs.empty());
    EXPECT_TRUE(saysNothing(response.minimum));
    EXPECT_EQ(response.pairs_unknown, response.pairs_total);
  }
}

}  // namespace proximity_server::node::load_test
