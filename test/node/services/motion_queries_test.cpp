#include "node/answers.h"
#include "node/asked_robot.h"
#include "node/limited_robot.h"
#include "node/object_messages.h"
#include "node/services/queries.h"
#include "robots/urdf.h"

#include <Eigen/Core>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

// Questions about motions. Every expected number is read off gantry.urdf and limits.urdf. With the gantry's ball at
// (x, 0, 0) it is x - 0.2 from the base.

namespace proximity_server::node::motion_queries_test {

constexpr double kMotionTolerance = 1e-6;  // [m] of the searches: the default of the requests
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
using node::saysNothing;

bool saysNothing(const MotionMinimum& minimum) {
  return std::isnan(minimum.lower_bound) && std::isnan(minimum.upper_bound) && std::isnan(minimum.time) &&
         saysNothing(minimum.pair);
}

/// The first contact happens at `paper` [s], and the distance then falls by `speed` [m/s].
template <class Response>
void expectContact(const Response& response, double paper, double speed) {
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_TRUE(response.contact);
  EXPECT_LE(response.t_free, paper + 1e-12);
  EXPECT_GE(response.t_free, paper - 3.0 * kMotionTolerance / speed);
  EXPECT_GE(response.t_contact, response.t_free);
  EXPECT_NEAR(response.t_contact, paper, 1.01 * kMotionTolerance / speed);
}

void expectMinimum(const MotionMinimum& minimum, double paper) {
  EXPECT_LE(minimum.lower_bound, paper + 1e-12);
  EXPECT_GE(minimum.upper_bound, paper - 1e-12);
  EXPECT_LE(minimum.upper_bound - minimum.lower_bound, 1.01 * kMotionTolerance);
  EXPECT_NEAR(minimum.pair.distance, paper, 1.01 * kMotionTolerance);
}

// ---- time_of_contact

FirstContactRequest between(const std::string& a, const std::string& b, const ros::Time& stamp) {
  auto request = node::between<FirstContactRequest>(a, b, stamp);
  request.horizon = 3.0;
  return request;
}

class TimeOfContact : public AskedGantry {
 protected:
  using AskedGantry::AskedGantry;

  /// Base and ball, whose joint moves.
  FirstContactRequest sliding(double velocity, const GantryPosition& start) {
    FirstContactRequest request = between("base", "ball", moveTo(start));
    request.joints.name = {"x_axis"};
    request.joints.velocity = {velocity};
    return request;
  }
};

geometry_msgs::Twist twist(const Eigen::Vector3d& linear, const Eigen::Vector3d& angular = Eigen::Vector3d::Zero()) {
  geometry_msgs::Twist result;
  result.linear.x = linear.x();
  result.linear.y = linear.y();
  result.linear.z = linear.z();
  result.angular.x = angular.x();
  result.angular.y = angular.y();
  result.angular.z = angular.z();
  return result;
}

void expectFailure(const FirstContactResponse& response, int code, const std::string& named) {
  expectRefusal(response, code, named);
  EXPECT_FALSE(response.contact);
  EXPECT_TRUE(std::isnan(response.t_free) && std::isnan(response.t_contact));
  EXPECT_TRUE(saysNothing(response.pair));
  EXPECT_TRUE(saysNothing(response.minimum));
}

TEST_F(TimeOfContact, OfBallAndBaseIsThatOfThePaper) {
  const auto request = sliding(-0.5, {1.0, 0.0, 0.0});
  const auto response = ask(request);
  expectContact(response, 1.6, 0.5);
  EXPECT_EQ(response.header.stamp, request.stamp);
  EXPECT_EQ(response.header.frame_id, "base");
  EXPECT_TRUE(saysNothing(response.minimum)) << "a contact needs no minimum";
}

TEST_F(TimeOfContact, GivesThePointsAsTheyAreThen) {
  const auto response = ask(sliding(-0.5, {1.0, 0.0, 0.0}));
  const Proximity& pair = response.pair;
  EXPECT_EQ(pair.a.link, "base");
  EXPECT_EQ(pair.b.link, "ball");
  EXPECT_NEAR(pair.distance, 0.0, 1.01 * kMotionTolerance);
  expectNear(pair.point_a, 0.1, 0.0, 0.0, 1e-5);
  expectNear(pair.point_b, 0.1, 0.0, 0.0, 1e-5);
  expectNear(pair.normal, 1.0, 0.0, 0.0, 1e-5);
  expectNear(pair.point_b_link, 0.0, 0.1, 0.0, 1e-5);  // the ball's frame is turned by a quarter about z
}

TEST_F(TimeOfContact, ComesEarlierWithAContactDistance) {
  auto request = sliding(-0.5, {1.0, 0.0, 0.0});
  request.contact_distance = 0.3;
  const auto response = ask(request);
  expectContact(response, 1.0, 0.5);
  EXPECT_NEAR(response.pair.distance, 0.3, 1.01 * kMotionTolerance);
}

TEST_F(TimeOfContact, IsAtTheStopDistanceIfTheContactDistanceIsNoNumber) {
  auto request = sliding(-0.5, {1.0, 0.0, 0.0});
  request.contact_distance = kNaN;
  const auto response = ask(request);
  EXPECT_EQ(response.status.code, QueryStatus::OK) << response.status.message;
  ASSERT_TRUE(response.contact);
  EXPECT_NEAR(response.pair.distance, 0.02, 1.01 * kMotionTolerance);  // the default of stop_distance
}

TEST_F(TimeOfContact, ReachesTheToleranceThatIsAsked) {
  auto request = sliding(-0.5, {1.0, 0.0, 0.0});
  request.tolerance = 1e-3;
  EXPECT_LE(ask(request).pair.distance, 1.01e-3);
  request.tolerance = 1e-9;
  EXPECT_LE(ask(request).pair.distance, 1.01e-9);
}

TEST_F(TimeOfContact, OfTwoInContactIsTheStart) {
  const auto response = ask(sliding(0.5, {0.15, 0.0, 0.0}));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_TRUE(response.contact);
  EXPECT_EQ(response.t_free, 0.0);
  EXPECT_EQ(response.t_contact, 0.0);
  EXPECT_NEAR(response.pair.distance, -0.05, kTolerance);
}

TEST_F(TimeOfContact, WithoutNamesIsThatOfTheFirstPair) {
  FirstContactRequest request;
  request.stamp = moveTo({0.0, 0.5, 0.0});
  request.horizon = 2.0;
  request.joints.name = {"y_axis"};
  request.joints.velocity = {0.5};
  const auto response = ask(request);  // 0.3 to the block
  expectContact(response, 0.6, 0.5);
  EXPECT_EQ(links(response.pair), (std::set<std::string>{"ball", "block"}));
}

TEST_F(TimeOfContact, ThatNeverComesIsProvenAndTheMinimumIsTold) {
  // Past the base at x = 0.5, along y: 0.3 away while the ball is beside the face, from 0.9 s to 1.1 s.
  auto request = between("base", "ball", moveTo({0.5, -1.0, -1.0}));
  request.joints.name = {"y_axis"};
  request.joints.velocity = {1.0};
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_FALSE(response.contact);
  EXPECT_EQ(response.t_free, 3.0);
  EXPECT_TRUE(std::isnan(response.t_contact));
  EXPECT_TRUE(saysNothing(response.pair));
  expectMinimum(response.minimum, 0.3);
  // Off the face by s the ball is s^2 / 0.8 farther: within the tolerance for s < 1e-3.
  EXPECT_GT(response.minimum.time, 0.898);
  EXPECT_LT(response.minimum.time, 1.102);
  EXPECT_NEAR(response.minimum.pair.point_b.x, 0.4, 1e-3);

  request.skip_minimum = true;
  EXPECT_TRUE(saysNothing(ask(request).minimum));
}

TEST_F(TimeOfContact, OfTwoThatRestIsNever) {
  const auto response = ask(sliding(0.0, {0.5, 0.0, 0.0}));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_FALSE(response.contact);
  EXPECT_EQ(response.t_free, 3.0);
  expectMinimum(response.minimum, 0.3);
}

TEST_F(TimeOfContact, StartsFromThePosesOfTheStamp) {
  const auto then = sliding(-0.5, {1.0, 0.0, 0.0});
  auto latest = sliding(-0.5, {0.7, 0.0, 0.0});
  expectContact(ask(latest), 1.0, 0.5);
  expectContact(ask(then), 1.6, 0.5);
  latest.stamp = ros::Time();
  expectContact(ask(latest), 1.0, 0.5);
}

// ---- twists

using Twist = AskedGantry;

TEST_F(Twist, IsTakenAlongTheAxesOfTheHeader) {
  auto request = between("base", "ball", moveTo({1.0, 0.0, 0.0}));
  request.links = {"ball"};
  request.twists = {twist({-0.5, 0.0, 0.0})};
  expectContact(ask(request), 1.6, 0.5);
}

TEST_F(Twist, TurnsALinkAboutItsOwnOriginWhateverCarriesIt) {
  // The low cube turns about z, its edge of 0.2 at a distance of 0.22 from the ball's centre: they touch when
  // 0.22 cos(t) = 0.1 + 0.1, with the foot still on the face. Its body has its frame a metre away, in the post.
  auto request = between("ball", "block", moveTo({0.0, 0.78, 0.0}));
  request.links = {"block"};
  request.twists = {twist({0.0, 0.0, 0.0}, {0.0, 0.0, 1.0})};
  const double paper = std::acos(0.2 / 0.22);
  expectContact(ask(request), paper, 0.22 * std::sin(paper));
}

TEST_F(Twist, OfLinksThatAreOneBodyMustAgree) {
  auto request = between("ball", "block", moveTo({0.0, 0.78, 0.0}));
  request.links = {"block", "post"};
  // Turning about the block's origin at (0, 1, 0), the post at (0, 0, 0) moves along +x.
  request.twists = {twist({0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}), twist({1.0, 0.0, 0.0}, {0.0, 0.0, 1.0})};
  EXPECT_TRUE(ask(request).contact);
  request.twists[1].linear.x = 0.9;
  expectFailure(ask(request), QueryStatus::INVALID_ARGUMENT, "'block' and 'post' disagree");
}

TEST_F(Twist, DoesNotMoveWhatHangsOnTheLink) {
  auto request = between("base", "ball", moveTo({1.0, 0.0, 0.0}));
  request.links = {"slide"};
  request.twists = {twist({-0.5, 0.0, 0.0})};
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_FALSE(response.contact);
}

TEST_F(Twist, OfTheReferenceFrameItselfIsRefused) {
  auto request = between("base", "ball", moveTo({1.0, 0.0, 0.0}));
  request.links = {"base", "ball"};
  request.twists = {twist({0.0, 0.0, 0.0}), twist({-0.5, 0.0, 0.0})};
  EXPECT_TRUE(ask(request).contact);
  request.twists[0].linear.x = 0.1;
  expectFailure(ask(request), QueryStatus::INVALID_ARGUMENT, "'base'");
}

// ---- the frame of a link that moves

class ReferenceFrameOfMotion : public TimeOfContact {
 protected:
  ReferenceFrameOfMotion() : TimeOfContact("ball") {}
};

TEST_F(ReferenceFrameOfMotion, OfALinkIsThatOfTheTimeOfContact) {
  const auto response = ask(sliding(-0.5, {1.0, 0.0, 0.0}));
  expectContact(response, 1.6, 0.5);
  EXPECT_EQ(response.header.frame_id, "ball");
  expectNear(response.pair.point_a, 0.0, 0.1, 0.0, 1e-5);  // towards the base is +y in the turned frame
  expectNear(response.pair.point_a_link, 0.1, 0.0, 0.0, 1e-5);
  expectNear(response.pair.normal, 0.0, -1.0, 0.0, 1e-5);
}

TEST_F(ReferenceFrameOfMotion, OfALinkIsWhatTwistsAreRelativeTo) {
  auto request = between("base", "ball", moveTo({1.0, 0.0, 0.0}));
  request.links = {"base"};
  request.twists = {twist({0.0, -0.5, 0.0})};
  const auto response = ask(request);
  expectContact(response, 1.6, 0.5);
  expectNear(response.pair.point_a, 0.0, 0.1, 0.0, 1e-5);
}

// A fixed object stands in the reference frame: in that of the ball it goes with the ball. Its centre is 0.3 nearer to
// the base, which is +y in the turned frame.
TEST_F(ReferenceFrameOfMotion, OfALinkCarriesFixedObjects) {
  const auto applied = ask(requestOf({addBall("part", poseAt(0, 0.3, 0))}));
  ASSERT_TRUE(applied.success) << applied.status.message;
  auto request = sliding(-0.5, {1.0, 0.0, 0.0});
  request.b = shape("part");
  const auto response = ask(request);
  expectContact(response, 1.0, 0.5);
  expectNear(response.pair.point_b, 0.0, 0.4, 0.0, 1e-5);
}

// ---- time budgets

using TimeBudget = TimeOfContact;

TEST_F(TimeBudget, ThatEndsLeavesWhatIsProven) {
  auto request = sliding(-0.5, {1.0, 0.0, 0.0});
  request.time_budget = ros::Duration(0, 1);
  const auto response = ask(request);
  expectRefusal(response, QueryStatus::OVER_BUDGET, "time budget");
  EXPECT_FALSE(response.contact);
  EXPECT_GE(response.t_free, 0.0);
  EXPECT_LE(response.t_free, 1.6);
  EXPECT_TRUE(std::isnan(response.t_contact));
  EXPECT_TRUE(saysNothing(response.pair));
}

// ---- joints at their limits, see limits.urdf

class JointLimits : public TimeOfContact {
 protected:
  ros::Time moveLimitedTo(double run, double turn) { return limited_.moveTo(LimitedRobot::all(run, turn)); }

  /// A request for two links of limits.urdf, one of whose joints moves.
  static FirstContactRequest moving(const std::string& a, const std::string& b, const std::string& joint,
                                    double velocity, const ros::Time& stamp) {
    FirstContactRequest request = between(a, b, stamp);
    request.ignore_filter = true;
    request.joints.name = {joint};
    request.joints.velocity = {velocity};
    return request;
  }

  /// Publishes joint_states.
  void stateTurn(double position, const ros::Time& stamp) {
    sensor_msgs::JointState state;
    state.header.stamp = stamp;
    state.name = {"turn"};
    state.position = {position};
    limited_.tf().stated().follow(limited_.robot());
    limited_.tf().stated().add(state, "joint_states");
  }

  AskedRobot limited_{{robotText("limits.urdf"), ""}};
};

void expectStops(const FirstContactResponse& response, const std::vector<std::string>& joints,
                 const std::vector<double>& times) {
  EXPECT_EQ(response.joints_at_limit, joints);
  ASSERT_EQ(response.limit_times.size(), times.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(response.limit_times[i], times[i], 1e-9);
}

void expectNoContact(const FirstContactResponse& response, double minimum) {
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_FALSE(response.contact);
  EXPECT_EQ(response.t_free, 3.0);
  expectMinimum(response.minimum, minimum);
}

TEST_F(JointLimits, StopAJointBeforeAContactThatLiesBeyond) {
  const auto response = limited_.ask(moving("wall", "ball", "run", -0.5, moveLimitedTo(1.0, 0.0)));
  expectNoContact(response, 0.3);  // without a limit there would be contact at 1.6 s
  expectStops(response, {"run"}, {1.0});
  EXPECT_GE(response.minimum.time, 1.0 - 1e-5);
}

TEST_F(JointLimits, AreToldBesideAContactThatComesBefore) {
  auto request = sliding(-0.5, {1.0, 0.0, 0.0});
  request.horizon = 10.0;
  const auto response = ask(request);
  expectContact(response, 1.6, 0.5);
  expectStops(response, {"x_axis"}, {6.0});
}

TEST_F(JointLimits, DoNotStopTwists) {
  FirstContactRequest request = between("wall", "ball", moveLimitedTo(1.0, 0.0));
  request.ignore_filter = true;
  request.links = {"ball"};
  request.twists = {twist({-0.5, 0.0, 0.0})};
  const auto response = limited_.ask(request);
  expectContact(response, 1.6, 0.5);
  expectStops(response, {}, {});
}

// At 6 rad, 0.25 before the limit, the hand stands as it does at 6 - 2 pi, from where it would reach the pin.
TEST_F(JointLimits, CountInTheTurnThatTheRequestTells) {
  auto request = moving("pin", "hand", "turn", 0.5, moveLimitedTo(1.0, 6.0));
  const double way = 0.5 - 2.0 * std::asin(0.1) - (6.0 - 2.0 * M_PI);
  expectContact(limited_.ask(request), way / 0.5, 0.5);
  request.joints.position = {kNaN};
  expectContact(limited_.ask(request), way / 0.5, 0.5);
  request.joints.position = {6.0};
  const auto response = limited_.ask(request);
  expectNoContact(response, 2.0 * std::sin((0.5 - (6.25 - 2.0 * M_PI)) / 2.0) - 0.2);
  expectStops(response, {"turn"}, {0.5});
  request.joints.position = {6.0, 6.0};
  expectFailure(limited_.ask(request), QueryStatus::INVALID_ARGUMENT, "2 positions for 1 names");
}

// Regression: the request had to tell the turn, although joint_states did.
TEST_F(JointLimits, CountInTheTurnThatJointStatesTell) {
  auto request = moving("pin", "hand", "turn", 0.5, moveLimitedTo(1.0, 6.0));
  const std::string assumed = "nothing tells the turn of 'turn': each is taken to stop as late as a turn allows";
  EXPECT_EQ(limited_.ask(request).status.message, assumed);
  request.horizon = 0.4;  // no limit is reached on any turn
  EXPECT_EQ(limited_.ask(request).status.message, "");
  request.horizon = 3.0;
  stateTurn(6.0, request.stamp);
  for (const std::vector<double>& unknown : {std::vector<double>{}, {kNaN}}) {
    request.joints.position = unknown;
    const auto response = limited_.ask(request);
    expectNoContact(response, 2.0 * std::sin((0.5 - (6.25 - 2.0 * M_PI)) / 2.0) - 0.2);
    expectStops(response, {"turn"}, {0.5});
    EXPECT_EQ(response.status.message, "");
  }
  request.joints.position = {6.0 - 2.0 * M_PI};  // the request tells another one
  EXPECT_TRUE(limited_.ask(request).contact);
  request.joints.position.clear();
  stateTurn(5.9, request.stamp);  // not as tf
  EXPECT_EQ(limited_.ask(request).status.message, assumed);
}

// Regression: a joint stated more than 0.05 rad beyond a limit was taken to be a turn away, within its limits.
TEST_F(JointLimits, AreThoseOfTheStatedTurnAlsoBeyondThem) {
  auto request = moving("pin", "hand", "turn", -0.5, moveLimitedTo(1.0, -6.35));
  request.joints.position = {-6.35};
  const auto response = limited_.ask(request);
  expectNoContact(response, 2.0 * std::sin((0.5 - (2.0 * M_PI - 6.35)) / 2.0) - 0.2);
  expectStops(response, {"turn"}, {0.0});
  request.joints.position = {9.5};  // more than half a turn beyond
  expectFailure(limited_.ask(request), QueryStatus::INVALID_ARGUMENT, "joints: joint 'turn' is stated to be at 9.5");
  request.joints.velocity = {0.0};
  EXPECT_TRUE(limited_.ask(request).success) << "it rests";
}

// ---- query_trajectory

using QueryTrajectory = AskedGantry;

struct WayPoint {
  double time;
  std::vector<double> positions;
};

/// A trajectory, for base and ball.
QueryTrajectoryRequest along(const std::vector<std::string>& joints, const std::vector<WayPoint>& points) {
  auto request = node::between<QueryTrajectoryRequest>("base", "ball");
  request.trajectory.joint_names = joints;
  for (const WayPoint& point : points) {
    trajectory_msgs::JointTrajectoryPoint message;
    message.positions = point.positions;
    message.time_from_start = ros::Duration(point.time);
    request.trajectory.points.push_back(message);
  }
  return request;
}

/// Towards the base, which it touches in the second segment: at x = 0.2, after 1 + 4 / 3 s.
QueryTrajectoryRequest towardsTheBase() {
  return along({"y_axis", "x_axis"}, {{0.0, {0.0, 1.0}}, {1.0, {0.0, 0.6}}, {3.0, {0.0, 0.0}}});
}

void expectFailure(const QueryTrajectoryResponse& response, int code, const std::string& named) {
  expectRefusal(response, code, named);
  EXPECT_FALSE(response.contact);
  EXPECT_TRUE(std::isnan(response.t_free) && std::isnan(response.t_contact));
  EXPECT_EQ(response.segment, -1);
  EXPECT_TRUE(response.state.name.empty() && response.segments.empty());
  EXPECT_TRUE(saysNothing(response.pair));
}

TEST_F(QueryTrajectory, FindsTheFirstContactItsSegmentAndState) {
  const auto response = ask(towardsTheBase());  // every joint is named: no tf is needed
  expectContact(response, 1.0 + 4.0 / 3.0, 0.3);
  EXPECT_TRUE(response.header.stamp.isZero());
  EXPECT_EQ(response.segment, 1);
  EXPECT_EQ(response.state.name, (std::vector<std::string>{"y_axis", "x_axis"}));
  ASSERT_EQ(response.state.position.size(), 2u);
  EXPECT_EQ(response.state.position[0], 0.0);
  EXPECT_NEAR(response.state.position[1], 0.2, 1.01 * kMotionTolerance);
  EXPECT_EQ(response.pair.b.link, "ball");
  expectNear(response.pair.point_b, 0.1, 0.0, 0.0, 1e-5);
}

TEST_F(QueryTrajectory, TellsTheMinimumOfEverySegment) {
  const auto response = ask(towardsTheBase());
  ASSERT_EQ(response.segments.size(), 2u);
  EXPECT_EQ(response.segments_finished, 2u);
  expectMinimum(response.segments[0], 0.4);
  EXPECT_NEAR(response.segments[0].time, 1.0, 1e-5);
  expectMinimum(response.segments[1], -0.2);  // with the ball's centre in that of the cube
  EXPECT_NEAR(response.segments[1].time, 3.0, 1e-5);
  EXPECT_EQ(response.segments[1].pair.state, Proximity::PENETRATING);
}

TEST_F(QueryTrajectory, KeepsTheClockOfTheTrajectory) {
  auto request = along({"x_axis", "y_axis"}, {{5.0, {1.0, 0.0}}, {9.0, {0.0, 0.0}}});
  request.contact_distance = 0.3;
  expectContact(ask(request), 7.0, 0.25);  // at x = 0.5
}

TEST_F(QueryTrajectory, WithoutContactIsProvenToItsEnd) {
  auto request = along({"x_axis", "y_axis"}, {{0.0, {1.0, 0.0}}, {1.0, {0.6, 0.0}}, {2.5, {0.8, 0.0}}});
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_FALSE(response.contact);
  EXPECT_EQ(response.t_free, 2.5);
  EXPECT_TRUE(std::isnan(response.t_contact));
  EXPECT_EQ(response.segment, -1);
  EXPECT_TRUE(response.state.name.empty());
  EXPECT_TRUE(saysNothing(response.pair));
  ASSERT_EQ(response.segments.size(), 2u);
  expectMinimum(response.segments[1], 0.4);

  request.skip_minimum = true;
  EXPECT_TRUE(ask(request).segments.empty());
}

TEST_F(QueryTrajectory, IsFollowedBeyondLimitsAndSaysSo) {
  const auto beyond = ask(along({"x_axis", "y_axis"}, {{0.0, {1.0, 0.0}}, {1.0, {2.5, -3.0}}, {2.0, {0.8, 0.0}}}));
  ASSERT_TRUE(beyond.success) << beyond.status.message;
  EXPECT_EQ(beyond.status.message,
            "point 1 is the first beyond a limit: joint 'x_axis' is at 2.5, its upper limit is 2");
  EXPECT_EQ(beyond.t_free, 2.0);
  const auto within = ask(along({"x_axis", "y_axis"}, {{0.0, {1.0, 0.0}}, {1.0, {2.0, -2.0}}}));
  EXPECT_EQ(within.status.message, "");
}

TEST_F(QueryTrajectory, LeavesJointsThatItDoesNotNameAsInTf) {
  auto request = along({"y_axis"}, {{0.0, {-1.0}}, {2.0, {1.0}}});
  request.stamp = moveTo({0.5, 0.0, 0.0});
  const auto beside = ask(request);
  ASSERT_TRUE(beside.success) << beside.status.message;
  EXPECT_EQ(beside.header.stamp, request.stamp);
  EXPECT_FALSE(beside.contact);
  expectMinimum(beside.segments.at(0), 0.3);

  request.missing_joints = QueryTrajectoryRequest::ZERO;
  expectContact(ask(request), 0.8, 1.0);  // at y = -0.2
}

TEST_F(ReferenceFrameOfMotion, OfALinkIsThatOfTheTimeOfContactOnATrajectory) {
  const auto response = ask(towardsTheBase());
  expectContact(response, 1.0 + 4.0 / 3.0, 0.3);
  expectNear(response.pair.point_a, 0.0, 0.1, 0.0, 1e-5);
}

TEST_F(TimeBudget, ThatEndsLeavesTheOtherSegmentsUnknown) {
  auto request = towardsTheBase();
  request.time_budget = ros::Duration(0, 1);
  const auto response = ask(request);
  expectRefusal(response, QueryStatus::OVER_BUDGET, "time budget");
  EXPECT_FALSE(response.contact);
  EXPECT_GE(response.t_free, 0.0);
  EXPECT_LE(response.t_free, 1.0 + 4.0 / 3.0);
  EXPECT_EQ(response.segments_finished, 0u);
  ASSERT_EQ(response.segments.size(), 2u);
  EXPECT_TRUE(saysNothing(response.segments[1]));
}

// ---- splines and tracking errors

/// A point of a spline; without accelerations or velocities their list is empty.
struct SplinePoint {
  double time;
  std::vector<double> positions, velocities{}, accelerations{};
};

QueryTrajectoryRequest alongSpline(std::uint8_t interpolation, const std::vector<std::string>& joints,
                                   const std::vector<SplinePoint>& points) {
  QueryTrajectoryRequest request = along(joints, {});
  request.interpolation = interpolation;
  for (const SplinePoint& point : points) {
    trajectory_msgs::JointTrajectoryPoint message;
    message.positions = point.positions;
    message.velocities = point.velocities;
    message.accelerations = point.accelerations;
    message.time_from_start = ros::Duration(point.time);
    request.trajectory.points.push_back(message);
  }
  return request;
}

constexpr std::uint8_t kCubic = QueryTrajectoryRequest::CUBIC, kQuintic = QueryTrajectoryRequest::QUINTIC;

/// From x = 0.6 back to 0.6 in 2 s, with velocities of -v and v: x(t) = 0.6 - v t + v t^2 / 2, lowest at 1 s with
/// 0.6 - v / 2.
QueryTrajectoryRequest dipping(double v) {
  return alongSpline(kCubic, {"x_axis", "y_axis"}, {{0.0, {0.6, 0.0}, {-v, 0.0}}, {2.0, {0.6, 0.0}, {v, 0.0}}});
}

using Spline = AskedGantry;

TEST_F(Spline, OvershootsWhereTheStraightLineDoesNot) {
  auto request = dipping(0.4);
  const auto cubic = ask(request);
  ASSERT_TRUE(cubic.success) << cubic.status.message;
  expectMinimum(cubic.segments.at(0), 0.4 - 0.2);
  EXPECT_NEAR(cubic.segments[0].time, 1.0, 5e-3);  // off by s s it is 0.2 s^2 farther
  EXPECT_NEAR(cubic.segments[0].pair.point_b.x, 0.4 - 0.1, 1e-5);
  EXPECT_EQ(cubic.certified, "the cubic splines of joint_trajectory_controller");
  EXPECT_FALSE(cubic.contact || cubic.may_touch);
  EXPECT_EQ(cubic.t_free, 2.0);
  request.interpolation = QueryTrajectoryRequest::LINEAR;
  const auto linear = ask(request);
  expectMinimum(linear.segments.at(0), 0.4);
  EXPECT_EQ(linear.certified, "the joints at constant velocity between the points");
}

TEST_F(Spline, FindsTheFirstContactItsSegmentAndState) {
  auto request = dipping(1.0);  // touches at x = 0.2: 0.6 - t + t^2 / 2 = 0.2
  const double paper = 1.0 - std::sqrt(0.2), speed = 1.0 - paper;
  const auto response = ask(request);
  expectContact(response, paper, speed);
  EXPECT_EQ(response.segment, 0);
  EXPECT_EQ(response.state.name, (std::vector<std::string>{"x_axis", "y_axis"}));
  ASSERT_EQ(response.state.position.size(), 2u);
  EXPECT_NEAR(response.state.position[0], 0.2, 1.01 * kMotionTolerance);
  expectNear(response.pair.point_b, 0.1, 0.0, 0.0, 1e-5);
  EXPECT_EQ(response.pair.b.link, "ball");
}

TEST_F(Spline, OfDegreeFiveTakesTheAccelerations) {
  // x(t) = 1 - t^2 / 4 from rest at x = 1 with an acceleration of -0.5 at both ends.
  const auto request =
      alongSpline(kQuintic, {"x_axis", "y_axis"},
                  {{0.0, {1.0, 0.0}, {0.0, 0.0}, {-0.5, 0.0}}, {2.0, {0.0, 0.0}, {-1.0, 0.0}, {-0.5, 0.0}}});
  const double paper = 2.0 * std::sqrt(0.8);
  const auto response = ask(request);
  expectContact(response, paper, 0.5 * paper);
  EXPECT_EQ(response.certified, "the quintic splines of joint_trajectory_controller");
}

TEST_F(Spline, IsOfTheLowerDegreeWhereAPointLacksData) {
  const auto request = alongSpline(kQuintic, {"x_axis", "y_axis"},
                                   {{0.0, {0.6, 0.0}},
                                    {1.0, {0.6, 0.0}, {-0.4, 0.0}},
                                    {3.0, {0.6, 0.0}, {0.4, 0.0}, {0.0, 0.0}},
                                    {4.0, {0.6, 0.0}, {-0.4, 0.0}, {0.0, 0.0}}});
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  expectMinimum(response.segments.at(0), 0.4);
  expectMinimum(response.segments.at(1), 0.2);
  EXPECT_EQ(response.certified,
            "the quintic splines of joint_trajectory_controller, where 1 of 3 segments are linear, as a point has no "
            "velocities, where 1 of 3 segments are cubic, as a point has no accelerations");
}

TEST_F(Spline, BeyondLimitsIsToldWithTimeAndJoint) {
  // From 1.9 to 1.9, x(t) = 1.9 + 0.4 t - 0.2 t^2: 2.1 after a second, beyond its limit of 2.
  auto request =
      alongSpline(kCubic, {"x_axis", "y_axis"}, {{0.0, {1.9, 0.0}, {0.4, 0.0}}, {2.0, {1.9, 0.0}, {-0.4, 0.0}}});
  const auto beyond = ask(request);
  ASSERT_TRUE(beyond.success) << beyond.status.message;
  EXPECT_EQ(beyond.status.message,
            "segment 0 is the first beyond a limit: at 1 s joint 'x_axis' is at 2.1, its upper limit is 2");
  request.trajectory.points[0].velocities[0] = 0.1;
  request.trajectory.points[1].velocities[0] = -0.1;
  EXPECT_EQ(ask(request).status.message, "");
}

TEST_F(Spline, LeavesJointsThatItDoesNotNameAsInTf) {
  auto request = alongSpline(kCubic, {"y_axis"}, {{0.0, {-1.0}, {0.0}}, {2.0, {1.0}, {0.0}}});
  request.stamp = moveTo({0.5, 0.0, 0.0});
  const auto beside = ask(request);
  ASSERT_TRUE(beside.success) << beside.status.message;
  EXPECT_EQ(beside.header.stamp, request.stamp);
  EXPECT_FALSE(beside.contact);
  expectMinimum(beside.segments.at(0), 0.3);
  request.missing_joints = QueryTrajectoryRequest::ZERO;
  EXPECT_TRUE(ask(request).contact);
}

TEST_F(Spline, SeesFixedObjects) {
  ASSERT_TRUE(ask(requestOf({addBall("part", poseAt(0.2, 0, 0))})).success);
  auto request = dipping(0.4);
  request.a = shape("part");
  request.b = shape("ball");
  expectMinimum(ask(request).segments.at(0), 0.4 - 0.2 - 0.1 - 0.1);
}

TEST_F(ReferenceFrameOfMotion, OfALinkIsThatOfTheContactOnASpline) {
  const auto response = ask(dipping(1.0));
  ASSERT_TRUE(response.contact) << response.status.message;
  EXPECT_EQ(response.header.frame_id, "ball");
  expectNear(response.pair.point_a, 0.0, 0.1, 0.0, 1e-5);  // towards the base is +y in the turned frame
  expectNear(response.pair.normal, 0.0, -1.0, 0.0, 1e-5);
}

TEST_F(ReferenceFrameOfMotion, OfALinkCarriesFixedObjectsAlongASpline) {
  ASSERT_TRUE(ask(requestOf({addBall("part", poseAt(0, 0.3, 0))})).success);
  auto request = dipping(0.6);  // touches at x = 0.5: 0.6 - 0.6 t + 0.3 t^2 = 0.5
  request.b = shape("part");
  const double paper = 1.0 - std::sqrt(2.0 / 3.0);
  const auto response = ask(request);
  expectContact(response, paper, 0.6 * (1.0 - paper));
}

using TrackingError = AskedGantry;

TEST_F(TrackingError, IsTakenOffTheDistance) {
  auto request = dipping(0.4);
  request.tracking_error = {0.05, 0.0};
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  expectMinimum(response.segments.at(0), 0.2 - 0.05);
  EXPECT_EQ(
      response.certified,
      "the cubic splines of joint_trajectory_controller, and all motions about them with \"x_axis\" off by at most "
      "0.05 m, \"y_axis\" off by at most 0 m");
  request.tracking_error = {0.01};  // of both; the ball is beside a face, so that only x counts at the nearest state
  const MotionMinimum of_both = ask(request).segments.at(0);
  EXPECT_LE(of_both.lower_bound, 0.19);
  EXPECT_GE(of_both.lower_bound, 0.18 - kMotionTolerance);
}

TEST_F(TrackingError, OfALinearMotionIsTakenOffToo) {
  auto request = along({"x_axis", "y_axis"}, {{0.0, {1.0, 0.0}}, {1.0, {0.6, 0.0}}});
  request.tracking_error = {0.1, 0.0};
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  expectMinimum(response.segments.at(0), 0.3);
  request.tracking_error = {0.0, 0.0};
  EXPECT_EQ(ask(request).certified, "the joints at constant velocity between the points");
}

TEST_F(TrackingError, EndsTheProofWhereAStateOfTheTubeTouches) {
  auto request = dipping(0.6);  // down to x = 0.3, and with 0.15 off to 0.15
  request.tracking_error = {0.15, 0.0};
  const auto response = ask(request);
  const double paper = 1.0 - std::sqrt(1.0 / 6.0);  // 0.6 - 0.6 t + 0.3 t^2 = 0.35
  expectContact(response, paper, 0.6 * (1.0 - paper));
  EXPECT_NEAR(response.state.position.at(0), 0.2, 1.01 * kMotionTolerance);
  EXPECT_NEAR(response.pair.distance, 0.0, 1.01 * kMotionTolerance);
}

// The tube of both joints is a box, and the bound of the distance adds what each joint can do: near the edge of the
// base no corner is as near as the sum.
TEST_F(TrackingError, ThatMayTouchWithoutAKnownStateIsToldAsUndecided) {
  auto request = along({"x_axis", "y_axis"}, {{0.0, {0.23, -0.05}}, {1.0, {0.23, 0.05}}});
  request.tracking_error = {0.02, 0.02};
  const auto response = ask(request);
  expectRefusal(response, QueryStatus::NOT_CONVERGED, "there may be a contact");
  EXPECT_TRUE(response.may_touch);
  EXPECT_FALSE(response.contact);
  EXPECT_TRUE(std::isnan(response.t_contact));
  EXPECT_EQ(response.t_free, 0.0);
  EXPECT_EQ(response.segment, -1);
  EXPECT_TRUE(response.state.name.empty());
  EXPECT_EQ(links(response.pair), (std::set<std::string>{"base", "ball"}));
  EXPECT_NEAR(response.pair.distance, 0.03, 1e-6);
}

// ---- from the present state

using PresentState = AskedGantry;

TEST_F(PresentState, IsWhereTheMotionBegins) {
  auto request = along({"x_axis", "y_axis"}, {{-1.0, {5.0, 5.0}}, {0.0, {3.0, 3.0}}, {2.0, {0.6, 0.0}}});
  request.from_present_state = true;
  request.contact_distance = 0.6;
  request.stamp = moveTo({1.0, 0.0, 0.0});
  const auto response = ask(request);
  expectContact(response, 1.0, 0.2);  // at x = 0.8
  EXPECT_EQ(response.header.stamp, request.stamp);
  EXPECT_EQ(response.segment, 0);
  EXPECT_EQ(response.segments.size(), 1u);
  EXPECT_EQ(response.certified, "the joints at constant velocity between the points, from the present state on");
}

TEST_F(PresentState, HasTheVelocitiesOfTheRequestOrRests) {
  auto request = alongSpline(kCubic, {"x_axis", "y_axis"}, {{2.0, {0.6, 0.0}, {0.4, 0.0}}});
  request.from_present_state = true;
  request.stamp = moveTo({0.6, 0.0, 0.0});
  request.present_velocities = {-0.4, 0.0};
  expectMinimum(ask(request).segments.at(0), 0.2);
  request.present_velocities.clear();
  // x(t) = 0.6 + 0.8 (s^3 - s^2) with s = t / 2, lowest at s = 2 / 3.
  expectMinimum(ask(request).segments.at(0), 0.4 - 0.8 * 4.0 / 27.0);
}

TEST_F(PresentState, NeedsTheJointsOfTheTrajectoryInTf) {
  auto request = along({"x_axis", "y_axis"}, {{2.0, {0.6, 0.0}}});
  request.from_present_state = true;
  expectFailure(ask(request), QueryStatus::TF_UNAVAILABLE, "_axis'");
}

// At 6 rad tf shows 6 - 2 pi = -0.28, which is within the limits of -6.25 and 6.25 as well.
TEST_F(JointLimits, TellTheTurnOfThePresentState) {
  QueryTrajectoryRequest request = node::between<QueryTrajectoryRequest>("pin", "hand", moveLimitedTo(1.0, 6.0));
  request.trajectory.joint_names = {"turn"};
  request.trajectory.points.resize(1);
  request.trajectory.points[0].time_from_start = ros::Duration(1.0);
  request.from_present_state = true;
  request.skip_minimum = true;
  request.contact_distance = 3.0;  // in contact from the start on: `state` is the present state
  const auto startsAt = [&](double next) {
    request.trajectory.points[0].positions = {next};
    const auto response = limited_.ask(request);
    return response.state.position.empty() ? kNaN : response.state.position[0];
  };
  EXPECT_NEAR(startsAt(6.2), 6.0, 1e-9);
  EXPECT_NEAR(startsAt(1.0), 6.0 - 2.0 * M_PI, 1e-9);
  EXPECT_NEAR(startsAt(-6.2), 6.0 - 2.0 * M_PI, 1e-9) << "6 - 4 pi is nearer, but beyond the limit";
}

class PresentTurn : public JointLimits {
 protected:
  QueryTrajectoryRequest wayTo(double next, const ros::Time& stamp) {
    QueryTrajectoryRequest request = node::between<QueryTrajectoryRequest>("pin", "hand", stamp);
    request.trajectory.joint_names = {"turn"};
    request.trajectory.points.resize(1);
    request.trajectory.points[0].time_from_start = ros::Duration(1.0);
    request.trajectory.points[0].positions = {next};
    request.from_present_state = true;
    return request;
  }
};

const std::string kFromPresent = "the joints at constant velocity between the points, from the present state on";

TEST_F(PresentTurn, IsThatOfJointStates) {
  auto request = wayTo(1.0, moveLimitedTo(1.0, 6.0));
  request.contact_distance = 3.0;  // in contact from the start on: `state` is the present state
  stateTurn(6.0, request.stamp);
  const auto response = limited_.ask(request);
  ASSERT_EQ(response.state.position.size(), 1u) << response.status.message;
  EXPECT_NEAR(response.state.position[0], 6.0, 1e-9);
  EXPECT_EQ(response.certified, kFromPresent);
}

TEST_F(PresentTurn, IsToldWhereItIsAssumed) {
  const auto request = wayTo(1.0, moveLimitedTo(1.0, 6.0));
  const auto expectAssumed = [&](const char* why) {
    const std::string text = limited_.ask(request).certified;
    EXPECT_EQ(text.find(kFromPresent + ", where \"turn\" is taken to be at -0.28318530717"), 0u) << why << ": " << text;
    EXPECT_NE(text.find(" rad, on the turn nearest to the first point: joint_states do not tell its turn"),
              std::string::npos)
        << text;
  };
  expectAssumed("nothing is on joint_states");
  stateTurn(6.0, request.stamp - ros::Duration(0.3));
  expectAssumed("it is old");
  stateTurn(5.0, request.stamp);
  expectAssumed("tf says otherwise");
  stateTurn(6.0 * 180.0 / M_PI, request.stamp);
  expectAssumed("it is in degrees");
  stateTurn(6.0 + 20.0 * M_PI, request.stamp);
  expectAssumed("it is far beyond the limits");
  stateTurn(6.0, request.stamp);
  EXPECT_EQ(limited_.ask(request).certified, kFromPresent);
}

TEST_F(PresentTurn, IsNoAssumptionWhereTheLimitsAllowOneOnly) {
  std::string urdf = robotText("limits.urdf");
  urdf.replace(urdf.find("upper=\"6.25\""), 12, "upper=\"6.00\"");
  AskedRobot narrower({urdf, ""});
  const auto textAt = [&](double turn) {
    return narrower.ask(wayTo(1.0, narrower.moveTo(LimitedRobot::all(1.0, turn)))).certified;
  };
  EXPECT_EQ(textAt(-0.1), kFromPresent);
  EXPECT_NE(textAt(0.1), kFromPresent) << "or 0.1 - 2 pi";
}

// An arm whose joints turn twice: a turn told by joint_states gives the same answer as a first point that tells it.
TEST(RandomPresentTurns, AreThoseOfAWayFromTheStatedPositions) {
  using namespace robots;
  const std::string two_turns = axis("0 0 1") + limits("-6.28", "6.28", "3");
  AskedRobot arm({urdfOf(link("base") + link("upper", ball("0.1", "0.5 0 0")) + link("lower", ball("0.1", "0.5 0 0")) +
                         link("post", ball("0.1", "0.55 0.6 0")) + joint("stand", "fixed", "base", "post", "") +
                         joint("shoulder", "revolute", "base", "upper", two_turns) +
                         joint("elbow", "revolute", "upper", "lower", origin("0.5 0 0") + two_turns)),
                  ""});
  std::mt19937 random(56);
  std::uniform_real_distribution<double> position(-6.28, 6.28);
  int other_turns = 0;
  for (int i = 0; i < 100; ++i) {
    const std::vector<double> start{position(random), position(random)}, end{position(random), position(random)};
    std::vector<geometry_msgs::TransformStamped> transforms(2);
    const std::vector<std::string> parents{"base", "upper"}, children{"upper", "lower"};
    for (std::size_t k = 0; k < 2; ++k) {
      transforms[k].header.frame_id = parents[k];
      transforms[k].child_frame_id = children[k];
      transforms[k].transform.translation.x = 0.5 * static_cast<double>(k);
      transforms[k].transform.rotation.z = std::sin(0.5 * start[k]);
      transforms[k].transform.rotation.w = std::cos(0.5 * start[k]);
    }
    auto told = along({"shoulder", "elbow"}, {{2.0, end}});
    told.a = shape("post");
    told.b = shape("lower");
    told.from_present_state = true;
    told.stamp = arm.moveTo(transforms);
    const auto before = arm.ask(told);
    sensor_msgs::JointState state;
    state.header.stamp = told.stamp;
    state.name = {"shoulder", "elbow"};
    state.position = start;
    arm.tf().stated().follow(arm.robot());
    arm.tf().stated().add(state, "joint_states");
    auto explicitly = along({"shoulder", "elbow"}, {{0.0, start}, {2.0, end}});
    explicitly.a = told.a;
    explicitly.b = told.b;
    const auto found = arm.ask(told), expected = arm.ask(explicitly);
    ASSERT_TRUE(found.success && expected.success) << found.status.message << expected.status.message;
    EXPECT_NEAR(found.t_free, expected.t_free, 1e-4) << i;
    EXPECT_EQ(found.contact, expected.contact) << i;
    EXPECT_NEAR(found.segments.at(0).lower_bound, expected.segments.at(0).lower_bound, 2.0 * kMotionTolerance) << i;
    EXPECT_EQ(found.certified, kFromPresent) << i;
    other_turns += std::abs(before.segments.at(0).lower_bound - found.segments.at(0).lower_bound) > 1e-3;
    EXPECT_NE(before.certified, kFromPresent) << i;
  }
  EXPECT_GT(other_turns, 10);
}

TEST_F(TimeBudget, ThatEndsOnASplineLeavesItOpen) {
  auto request = dipping(1.0);
  request.time_budget = ros::Duration(0, 1);
  const auto response = ask(request);
  expectRefusal(response, QueryStatus::OVER_BUDGET, "time budget");
  EXPECT_FALSE(response.contact);
  EXPECT_TRUE(response.may_touch);
  EXPECT_LE(response.t_free, 1.0 - std::sqrt(0.2));
}

}  // namespace proximity_server::node::motion_queries_test
