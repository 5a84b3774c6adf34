#include <proximity_server/Clearance.h>
#include "node/answers.h"
#include "node/gantry.h"
#include "node/settings.h"
#include "tools/program/run_command.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <rosgraph_msgs/Log.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

// Every expected number is read off gantry.urdf and clearance.test. With the ball at (x, 0, 0) the clearance is
// x - 0.2, between base and ball.

namespace proximity_server::node::clearance_test {

std::string explain(const Clearance& clearance) {
  return "level " + std::to_string(clearance.level) + ", " + clearance.status.message;
}

/// The robot in motion, and what the node says about it.
class ClearanceTopic : public testing::Test {
 protected:
  static Gantry& gantry() { return connectedGantry(4); }  // all nodes but those with a tf of their own

  void TearDown() override { gantry().release(); }

  void hold(double x) { gantry().hold({x, 0.0, 0.0}); }

  /// The next message with this distance of the closest pair.
  std::optional<Clearance> at(double distance) {
    return inbox_.next(
        [&](const Clearance& message) { return std::abs(message.minimum.distance - distance) <= kTolerance; });
  }
  std::optional<Clearance> withLevel(std::uint8_t level) {
    return inbox_.next([&](const Clearance& message) { return message.level == level; });
  }

  Inbox<Clearance> inbox_{ros::NodeHandle(), "/proximity_server/clearance"};
};

TEST_F(ClearanceTopic, FollowsTheDistance) {
  const std::pair<double, int> rows[] = {
      {0.4, Clearance::CLEAR}, {0.24, Clearance::WARN}, {0.21, Clearance::STOP}, {0.15, Clearance::COLLISION}};
  for (const auto& [x, level] : rows) {
    hold(x);
    const auto message = at(x - 0.2);
    ASSERT_TRUE(message) << "x = " << x;
    EXPECT_EQ(message->level, level) << explain(*message);
    EXPECT_EQ(message->status.code, QueryStatus::OK);
    EXPECT_TRUE(message->minimum.a.link == "base" || message->minimum.b.link == "base");
  }
}

TEST_F(ClearanceTopic, KeepsALevelUntilTheHysteresisIsLeft) {
  hold(0.215);
  ASSERT_TRUE(withLevel(Clearance::STOP));
  hold(0.225);  // stop_distance is 0.02, hysteresis 0.01
  const auto within = at(0.025);
  ASSERT_TRUE(within);
  EXPECT_EQ(within->level, Clearance::STOP);
  hold(0.235);
  const auto left = at(0.035);
  ASSERT_TRUE(left);
  EXPECT_EQ(left->level, Clearance::WARN);
  hold(0.225);
  const auto back = at(0.025);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->level, Clearance::WARN);
}

TEST_F(ClearanceTopic, CarriesTheTimeAndFrameOfThePoses) {
  hold(0.4);
  const auto message = at(0.2);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->header.frame_id, "base");
  EXPECT_EQ(message->tf_skew, ros::Duration(0.0));  // all joints carry the same stamp
  EXPECT_LE(message->tf_age.toSec(), 1.0);          // max_tf_age
  const auto next = inbox_.next();
  ASSERT_TRUE(next);
  EXPECT_GT(next->cycle, message->cycle);
}

TEST_F(ClearanceTopic, ListsThePairsBelowTheThresholdClosestFirst) {
  gantry().hold({0.0, 0.55, 0.0});  // 0.25 from the block, 0.35 from the base; the threshold is 0.5
  const auto two = at(0.25);
  ASSERT_TRUE(two);
  EXPECT_EQ(two->pairs_below_threshold, 2u);
  ASSERT_EQ(two->below_threshold.size(), 2u);
  EXPECT_NEAR(two->below_threshold[0].distance, 0.25, kTolerance);
  EXPECT_NEAR(two->below_threshold[1].distance, 0.35, kTolerance);

  hold(0.4);  // 0.2 from the base, hypot(0.3, 0.9) - 0.1 = 0.85 from the block
  const auto one = at(0.2);
  ASSERT_TRUE(one);
  ASSERT_EQ(one->below_threshold.size(), 1u);
  EXPECT_NEAR(one->below_threshold[0].distance, 0.2, kTolerance);
}

TEST_F(ClearanceTopic, NamesTheClosestPairAlsoBeyondTheThreshold) {
  hold(1.0);
  const auto message = at(0.8);
  ASSERT_TRUE(message);
  EXPECT_TRUE(message->below_threshold.empty());
  EXPECT_EQ(message->minimum.state, Proximity::SEPARATED);
}

TEST_F(ClearanceTopic, TurnsInvalidWhenTransformsStopAndBackWhenTheyResume) {
  hold(0.4);
  ASSERT_TRUE(at(0.2));
  gantry().release();
  const auto stale = withLevel(Clearance::INVALID);
  ASSERT_TRUE(stale);
  EXPECT_EQ(stale->status.code, QueryStatus::TF_STALE);
  EXPECT_NE(stale->status.message.find("joint '"), std::string::npos) << stale->status.message;
  EXPECT_TRUE(saysNothing(stale->minimum));
  EXPECT_TRUE(stale->below_threshold.empty());
  EXPECT_EQ(stale->pairs_unknown, 2u);
  hold(0.4);
  ASSERT_TRUE(at(0.2));
}

TEST_F(ClearanceTopic, IsInvalidWhileOneJointIsMissing) {
  hold(0.4);
  ASSERT_TRUE(at(0.2));
  gantry().release();
  ASSERT_TRUE(withLevel(Clearance::INVALID));
  // The lift stands still in time, and the common time with it.
  const auto old = inbox_.next([&](const Clearance& message) {
    gantry().publish(Gantry::slide({0.4, 0.0, 0.0}), ros::Time::now());
    gantry().publish(Gantry::ball({0.4, 0.0, 0.0}), ros::Time::now());
    return message.tf_skew > ros::Duration(1.0);
  });
  ASSERT_TRUE(old);
  EXPECT_EQ(old->level, Clearance::INVALID);
  EXPECT_NE(old->status.message.find("'lift'"), std::string::npos) << old->status.message;
}

// Regression: the node logged nothing while its level was INVALID.
TEST_F(ClearanceTopic, LogsWhyItIsInvalidNotMoreThanOnceWithinTenSeconds) {
  Inbox<rosgraph_msgs::Log> log(ros::NodeHandle(), "/rosout");
  hold(0.4);
  ASSERT_TRUE(at(0.2));
  gantry().release();
  const auto is_warning = [](const rosgraph_msgs::Log& entry) {
    return entry.name == "/proximity_server" && entry.level == rosgraph_msgs::Log::WARN &&
           entry.msg.find("~clearance is INVALID: ") == 0;
  };
  std::optional<rosgraph_msgs::Log> first = log.next(is_warning), second = log.next(is_warning);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->msg.find("~clearance is INVALID: TF_STALE: "), 0u) << first->msg;
  EXPECT_NE(first->msg.find("joint '"), std::string::npos) << first->msg;
  EXPECT_GE((second->header.stamp - first->header.stamp).toSec(), 9.9);
}

TEST_F(ClearanceTopic, TakesNewSettingsWhileItRuns) {
  hold(0.4);
  const auto before = at(0.2);
  ASSERT_TRUE(before);
  EXPECT_EQ(before->level, Clearance::CLEAR);

  set("/proximity_server/", "warn_distance", 0.25);
  EXPECT_TRUE(withLevel(Clearance::WARN));
  set("/proximity_server/", "warn_distance", 0.05);
  EXPECT_TRUE(withLevel(Clearance::CLEAR));
}

/// Whether the node takes the value, and what it then works with.
std::pair<bool, double> settingAfter(const std::string& name, double value) {
  dynamic_reconfigure::ReconfigureRequest request = settingOf(name, value);
  dynamic_reconfigure::ReconfigureResponse response;
  const bool is_taken = ros::service::call("/proximity_server/set_parameters", request, response);
  if (!is_taken) {
    Inbox<dynamic_reconfigure::Config> updates(ros::NodeHandle(), "/proximity_server/parameter_updates");
    if (const auto update = updates.next()) response.config = *update;
  }
  for (const auto& number : response.config.doubles) {
    if (number.name == name) return {is_taken, number.value};
  }
  return {is_taken, -1.0};
}

TEST_F(ClearanceTopic, RefusesSettingsThatContradictEachOtherOrAreOutOfRangeAndKeepsThoseInForce) {
  using Outcome = std::pair<bool, double>;
  EXPECT_EQ(settingAfter("stop_distance", 0.2), Outcome(false, 0.02));  // warn_distance is 0.05
  EXPECT_EQ(settingAfter("warn_distance", 0.01), Outcome(false, 0.05));
  EXPECT_EQ(settingAfter("hysteresis", -1.0).first, false);
  EXPECT_EQ(settingAfter("no_such_parameter", 1.0), Outcome(false, -1.0));
  for (const std::string name : {"threshold", "rate", "lookahead", "stop_distance"}) {
    const auto [is_taken, kept] = settingAfter(name, std::nan(""));
    EXPECT_FALSE(is_taken) << name;
    EXPECT_FALSE(std::isnan(kept)) << name;
  }
  EXPECT_EQ(settingAfter("stop_distance", 0.03), Outcome(true, 0.03));
  EXPECT_EQ(settingAfter("stop_distance", 0.02), Outcome(true, 0.02));
  double stored = 0.0;
  ASSERT_TRUE(ros::param::get("/proximity_server/warn_distance", stored));
  EXPECT_EQ(stored, 0.05);
}

tools::CommandResult dynparam(const std::string& arguments) {
  return tools::runCommand("rosrun dynamic_reconfigure dynparam set /proximity_server " + arguments + " 2>&1");
}

// Regression: it ended with 0, and the reason was in the log of the node alone.
TEST_F(ClearanceTopic, LetsDynparamFailWithTheReasonWhereItRefusesAValue) {
  const auto contradiction = dynparam("stop_distance 0.2"), range = dynparam("rate 5000"),
             right = dynparam("stop_distance 0.02");
  EXPECT_EQ(contradiction.exit_code, 1);
  const std::string reason = "stop_distance is 0.2, above warn_distance, which is 0.05";
  EXPECT_NE(contradiction.output.find(reason), std::string::npos) << contradiction.output;
  EXPECT_EQ(range.exit_code, 1);
  EXPECT_NE(range.output.find("/proximity_server/rate"), std::string::npos) << range.output;
  EXPECT_EQ(right.exit_code, 0) << right.output;
}

// Regression: it said nothing of them, and users believed that they had changed.
TEST_F(ClearanceTopic, ReloadNamesTheLiveParametersThatItLeaves) {
  const auto reload = [] {
    return call<std_srvs::TriggerResponse>("/proximity_server/reload", std_srvs::TriggerRequest()).message;
  };
  EXPECT_EQ(reload().find("live parameters"), std::string::npos);
  ros::param::set("/proximity_server/warn_distance", 0.25);
  const std::string message = reload();
  EXPECT_NE(message.find("unlike on the parameter server: warn_distance is 0.05, there it is 0.25; the service"),
            std::string::npos)
      << message;
  ros::param::set("/proximity_server/warn_distance", 0.05);
  hold(0.4);
  const auto after = at(0.2);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->level, Clearance::CLEAR);
}

TEST_F(ClearanceTopic, IsSilentWhileTheMonitorIsDisabled) {
  hold(0.4);
  Inbox<diagnostic_msgs::DiagnosticArray> diagnostics(ros::NodeHandle(), "/diagnostics");
  const auto saysDisabled = [](const diagnostic_msgs::DiagnosticArray& message) {
    return std::any_of(
        message.status.begin(), message.status.end(), [](const diagnostic_msgs::DiagnosticStatus& status) {
          return status.name == "proximity_server: clearance" && status.message == "the monitor is disabled";
        });
  };
  std_srvs::SetBoolRequest request;
  request.data = false;
  EXPECT_TRUE(call<std_srvs::SetBoolResponse>("/proximity_server/enable_monitor", request).success);
  ASSERT_TRUE(diagnostics.next(saysDisabled));
  inbox_.clear();
  ASSERT_TRUE(diagnostics.next(saysDisabled));  // a second later
  EXPECT_EQ(inbox_.clear(), 0u);
  request.data = true;
  EXPECT_TRUE(call<std_srvs::SetBoolResponse>("/proximity_server/enable_monitor", request).success);
  EXPECT_TRUE(at(0.2));
}

TEST_F(ClearanceTopic, ComesWithDiagnosticsOfEveryPart) {
  hold(0.4);
  ASSERT_TRUE(at(0.2));
  Inbox<diagnostic_msgs::DiagnosticArray> diagnostics(ros::NodeHandle(), "/diagnostics");
  const std::set<std::string> expected = {"proximity_server: tf",        "proximity_server: model",
                                          "proximity_server: clearance", "proximity_server: timing",
                                          "proximity_server: record",    "proximity_server: objects"};
  const auto healthy = diagnostics.next([&](const diagnostic_msgs::DiagnosticArray& message) {
    std::set<std::string> names;
    for (const auto& status : message.status) {
      if (status.level == diagnostic_msgs::DiagnosticStatus::OK) names.insert(status.name);
    }
    return names == expected;
  });
  EXPECT_TRUE(healthy);
  gantry().release();
  const auto ill = diagnostics.next([](const diagnostic_msgs::DiagnosticArray& message) {
    return std::any_of(
        message.status.begin(), message.status.end(), [](const diagnostic_msgs::DiagnosticStatus& status) {
          return status.name == "proximity_server: tf" && status.level == diagnostic_msgs::DiagnosticStatus::ERROR;
        });
  });
  EXPECT_TRUE(ill);
}

// ---- markers

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

TEST_F(ClearanceTopic, MarkersShowThePiecesOnceToEveryNewcomer) {
  hold(0.4);
  for (int newcomer = 0; newcomer < 2; ++newcomer) {
    Inbox<MarkerArray> markers(ros::NodeHandle(), "/proximity_server/markers");
    const auto drawsPieces = [](const MarkerArray& array) {
      return !array.markers.empty() && array.markers.front().ns == "pieces";
    };
    const auto pieces = markers.next(drawsPieces);
    ASSERT_TRUE(pieces);
    std::multiset<std::string> frames;
    for (const Marker& marker : pieces->markers) {
      EXPECT_TRUE(marker.frame_locked);
      frames.insert(marker.header.frame_id);
    }
    EXPECT_EQ(frames, (std::multiset<std::string>{"ball", "base", "block", "block"}));
  }
}

TEST_F(ClearanceTopic, MarkersJoinTheClosestPointsAndTellTheDistance) {
  hold(0.24);
  Inbox<MarkerArray> markers(ros::NodeHandle(), "/proximity_server/markers");
  const auto find = [](const MarkerArray& array, const std::string& ns) {
    return std::find_if(array.markers.begin(), array.markers.end(),
                        [&](const Marker& marker) { return marker.ns == ns && marker.action == Marker::ADD; });
  };
  const auto array = markers.next([&](const MarkerArray& candidate) {
    const auto level = find(candidate, "level");
    return level != candidate.markers.end() && level->text == "WARN\nbase is 40.0 mm from ball; warn below 50\nmm";
  });
  ASSERT_TRUE(array);
  const auto lines = find(*array, "witnesses");
  ASSERT_NE(lines, array->markers.end());
  ASSERT_EQ(lines->points.size(), 2u);
  EXPECT_NEAR(std::min(lines->points[0].x, lines->points[1].x), 0.1, kTolerance);
  EXPECT_NEAR(std::max(lines->points[0].x, lines->points[1].x), 0.14, kTolerance);
  EXPECT_EQ(lines->header.frame_id, "base");
  const auto closest = find(*array, "deciding");
  ASSERT_NE(closest, array->markers.end());
  EXPECT_EQ(closest->points, lines->points);
  EXPECT_GT(find(*array, "level")->pose.position.z, 0.6);  // the top of the block
}

// ---- other nodes

TEST_F(ClearanceTopic, InTheFrameOfALinkMovesWithIt) {
  hold(0.5);
  Inbox<Clearance> inbox(ros::NodeHandle(), "/in_ball/clearance");
  const auto message =
      inbox.next([](const Clearance& candidate) { return std::abs(candidate.minimum.distance - 0.3) <= kTolerance; });
  ASSERT_TRUE(message);
  EXPECT_EQ(message->header.frame_id, "ball");
  // Towards the base is +y in the turned frame.
  const bool base_first = message->minimum.a.link == "base";
  EXPECT_NEAR((base_first ? message->minimum.point_b : message->minimum.point_a).y, 0.1, kTolerance);
  EXPECT_NEAR((base_first ? message->minimum.point_a : message->minimum.point_b).y, 0.4, kTolerance);
}

TEST_F(ClearanceTopic, InAForeignFrameNeedsItsTransform) {
  hold(0.5);
  Inbox<Clearance> inbox(ros::NodeHandle(), "/in_world/clearance");
  const auto without = inbox.next();
  ASSERT_TRUE(without);
  EXPECT_EQ(without->level, Clearance::INVALID);
  EXPECT_NE(without->status.message.find("'world'"), std::string::npos) << without->status.message;

  geometry_msgs::TransformStamped world = Gantry::slide({0.0, 0.0, 0.0});
  world.header.frame_id = "world";
  world.child_frame_id = "base";
  world.transform.translation.z = 2.0;
  const auto with = inbox.next([&](const Clearance& candidate) {
    gantry().publish(world, ros::Time::now());
    return candidate.level != Clearance::INVALID;
  });
  ASSERT_TRUE(with);
  EXPECT_EQ(with->header.frame_id, "world");
  EXPECT_NEAR(with->minimum.point_a.z, 2.0, kTolerance);
  EXPECT_NEAR(with->minimum.point_b.z, 2.0, kTolerance);
}

TEST_F(ClearanceTopic, IsThatOfThePaddedShapes) {
  hold(0.5);
  Inbox<Clearance> inbox(ros::NodeHandle(), "/padded/clearance");
  const auto message = inbox.next([](const Clearance& candidate) { return candidate.level != Clearance::INVALID; });
  ASSERT_TRUE(message);
  EXPECT_NEAR(message->minimum.distance, 0.3 - 0.02 - 0.03 - 0.05, kTolerance);
  EXPECT_EQ(message->pairs_filtered, 2u);
  EXPECT_EQ(message->pairs_below_threshold, 1u);
  EXPECT_TRUE(message->below_threshold.empty()) << "max_reported_pairs is 0";
}

TEST(OnTf, OneCyclePerSetOfTransforms) {
  Inbox<Clearance> inbox(ros::NodeHandle(), "/on_tf/clearance");
  Gantry gantry(ros::NodeHandle(), "/on_tf/tf");
  ASSERT_TRUE(gantry.awaitListeners(1));
  std::uint64_t cycle = 0;
  for (int n = 0; n < 20; ++n) {
    const ros::Time stamp = gantry.moveTo({0.4 + 0.01 * n, 0.0, 0.0});
    const auto message = inbox.next([&](const Clearance& candidate) {
      return candidate.header.stamp == stamp && candidate.level != Clearance::INVALID;
    });
    ASSERT_TRUE(message);
    EXPECT_NEAR(message->minimum.distance, 0.2 + 0.01 * n, kTolerance);
    EXPECT_GT(message->cycle, cycle);
    cycle = message->cycle;
  }
}

TEST(LateTf, IsInvalidFromTheFirstCycleAndValidOnceTransformsCome) {
  Inbox<Clearance> inbox(ros::NodeHandle(), "/late/clearance");
  const auto before = inbox.next();
  ASSERT_TRUE(before);
  EXPECT_EQ(before->level, Clearance::INVALID);
  EXPECT_EQ(before->status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_TRUE(before->header.stamp.isZero()) << "there is no time of poses that are not known";
  EXPECT_NE(before->status.message.find("joint '"), std::string::npos) << before->status.message;

  Gantry gantry(ros::NodeHandle(), "/late/tf");
  gantry.hold({0.4, 0.0, 0.0});
  const auto after = inbox.next([](const Clearance& message) { return message.level != Clearance::INVALID; });
  ASSERT_TRUE(after);
  EXPECT_NEAR(after->minimum.distance, 0.2, kTolerance);
}

}  // namespace proximity_server::node::clearance_test
