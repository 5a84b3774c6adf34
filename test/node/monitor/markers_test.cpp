#include "node/monitor/markers.h"

#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "robots/urdf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::node::markers_test {

using namespace narrowphase;
using namespace scene;

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

using namespace robots;

/// A robot of one link with this geometry.
Robot robotOf(const std::string& geometry) { return {urdfOf(link("l", geometry)), "", Config()}; }

std::map<int, int> typesOf(const MarkerArray& array) {
  std::map<int, int> count;
  for (const Marker& marker : array.markers) ++count[marker.type];
  return count;
}

TEST(PieceMarkers, OfPrimitivesHaveTheirSizeAndPlace) {
  const MarkerArray array = pieceMarkers(robotOf(box("0.1 0.2 0.3", "1 2 3")));
  ASSERT_EQ(array.markers.size(), 1u);
  const Marker& box = array.markers[0];
  EXPECT_EQ(box.type, Marker::CUBE);
  EXPECT_EQ(box.header.frame_id, "l");
  EXPECT_NEAR(box.scale.y, 0.2, 1e-15);
  EXPECT_NEAR(box.pose.position.z, 3.0, 1e-15);
}

TEST(PieceMarkers, OfACapsuleAreACylinderAndTwoBalls) {
  const MarkerArray array =
      pieceMarkers(robotOf(cylinder("0.1", "0.4") + ball("0.1", "0 0 0.2") + ball("0.1", "0 0 -0.2")));
  EXPECT_EQ(typesOf(array), (std::map<int, int>{{Marker::CYLINDER, 1}, {Marker::SPHERE, 2}}));
}

TEST(PieceMarkers, OfAVisualThatCountsHaveANameOfTheirOwn) {
  const std::string seen = "<visual><geometry><sphere radius='0.1'/></geometry></visual>";
  Config config;
  config.model.collision_from_visual = {kAllLinks};
  const Robot robot(urdfOf(link("l", box("1 1 1") + seen) + link("m", seen) + weld("w", "l", "m")), "", config);
  const MarkerArray array = pieceMarkers(robot);
  ASSERT_EQ(array.markers.size(), 2u);
  EXPECT_EQ(array.markers[0].ns, "pieces");
  EXPECT_EQ(array.markers[1].ns, "pieces_from_visual");
}

/// A table from (-1, -1, 0) to (1, 1, 0.5), and a mast on it to z = 2, along which "lift" carries a sphere of radius
/// 0.1.
const std::string kMast =
    urdfOf(link("base", box("2 2 0.5", "0 0 0.25") + box("0.1 0.1 2", "0 0 1")) + link("ball", ball("0.1")) +
           joint("lift", "prismatic", "base", "ball", origin("0.5 0 0") + axis("0 0 1") + limits("0", "5")));

RobotModel mast() { return loadRobotModel(kMast, packageResolver({})); }
BodyPoses liftedTo(double height) { return forwardKinematics(mast(), std::vector<double>{height}); }

/// The marker of this name and number.
const Marker& find(const MarkerArray& array, const std::string& ns, int id = 0) {
  const auto is_it = [&](const Marker& marker) { return marker.ns == ns && marker.id == id; };
  const auto hit = std::find_if(array.markers.begin(), array.markers.end(), is_it);
  if (hit == array.markers.end()) throw std::out_of_range(ns);
  return *hit;
}

/// The closest pair first, each between the surfaces of base and ball, or another part, at y = distance; the level is
/// that of the default thresholds.
Clearance clearanceWith(const std::vector<double>& distances) {
  Clearance clearance;
  clearance.header.frame_id = "base";
  clearance.header.stamp = ros::Time(7.0);
  for (const double distance : distances) {
    Proximity pair;
    pair.a.link = "base";
    pair.b.link = clearance.below_threshold.empty() ? "ball" : "part " + std::to_string(clearance.levels.size());
    pair.distance = distance;
    pair.points_valid = true;
    pair.point_a.x = pair.point_b.x = 0.5;
    pair.point_b.y = distance;
    pair.point_a.z = pair.point_b.z = 1.0;
    clearance.below_threshold.push_back(pair);
    clearance.levels.push_back(static_cast<std::uint8_t>(levelOf(distance, 0.02, 0.05).level));
  }
  clearance.minimum = clearance.deciding = clearance.below_threshold.at(0);
  clearance.level = clearance.levels[0];
  clearance.deciding_threshold = levelOf(distances[0], 0.02, 0.05).threshold;
  return clearance;
}

Clearance invalidBecause(const std::string& reason) {
  Clearance clearance = clearanceWith({0.01, 0.2});
  clearance.level = Clearance::INVALID;
  clearance.status.code = QueryStatus::TF_STALE;
  clearance.status.message = reason;
  return clearance;
}

MarkerArray draw(const Clearance& clearance, double height = 1.0, const MonitorSettings& settings = {}) {
  return ClearanceMarkers(mast()).draw(clearance, liftedTo(height), settings);
}

bool isRed(const std_msgs::ColorRGBA& colour) { return colour.r > colour.g; }
bool isGreen(const std_msgs::ColorRGBA& colour) { return colour.g > colour.r; }

TEST(LevelText, TellsTheLevelAndTheMessageInTheColourOfTheLevel) {
  Clearance at_stop = clearanceWith({0.0123, 0.2});
  at_stop.status.message = "base is 12.3 mm from ball, closing 80 mm/s by lift; stop below 20 mm";
  const Marker stop = find(draw(at_stop), "level");
  EXPECT_EQ(stop.type, Marker::TEXT_VIEW_FACING);
  EXPECT_EQ(stop.text, "STOP\nbase is 12.3 mm from ball, closing 80 mm/s\nby lift; stop below 20 mm");
  EXPECT_TRUE(isRed(stop.color));
  EXPECT_TRUE(isGreen(find(draw(clearanceWith({0.25})), "level").color));
}

TEST(LevelText, StandsAboveTheRobotWhereverItsJointsAre) {
  const auto lowest = [](double height) {
    const Marker text = find(draw(clearanceWith({0.0123}), height), "level");
    EXPECT_NEAR(text.pose.position.x, 0.0, 1e-12);
    EXPECT_NEAR(text.pose.position.y, 0.0, 1e-12);
    EXPECT_EQ(text.header.frame_id, "base");
    return text.pose.position.z - 1.2 * text.scale.z;  // of two lines
  };
  EXPECT_GT(lowest(1.0), 2.0);
  EXPECT_LT(lowest(1.0), 2.5);
  EXPECT_NEAR(lowest(4.0) - lowest(1.0), 2.1, 1e-12);  // the top is the ball's, at 4.1
}

TEST(LevelText, HasASizeThatIsThatOfTheRobotAndKeepsIt) {
  const double size = find(draw(clearanceWith({0.0123}), 1.0), "level").scale.z;
  EXPECT_GT(size, 0.05);  // of a robot of 3 m from corner to corner
  EXPECT_LT(size, 0.2);
  EXPECT_EQ(find(draw(clearanceWith({0.0123}), 4.0), "level").scale.z, size);
}

TEST(LevelText, TellsWhyThereIsNoLevelAndLeavesNothingElse) {
  const MarkerArray array = draw(invalidBecause("joint 'lift': its transform is 5 s old"));
  const Marker text = find(array, "level");
  EXPECT_EQ(text.action, Marker::ADD);
  EXPECT_EQ(text.text, "INVALID\njoint 'lift': its transform is 5 s old");
  EXPECT_TRUE(isRed(text.color));
  EXPECT_TRUE(text.header.stamp.isZero()) << "the viewer has no transform of now either";
  for (const Marker& marker : array.markers) {
    if (marker.ns == "level") continue;
    EXPECT_EQ(marker.action, Marker::DELETE) << marker.ns;
  }
}

TEST(LevelText, DividesALongReasonBetweenWords) {
  const Marker text = find(
      draw(invalidBecause("there is no transform from 'base' to 'ball', which joint 'lift' should carry")), "level");
  EXPECT_EQ(text.text, "INVALID\nthere is no transform from 'base' to 'ball',\nwhich joint 'lift' should carry");
}

TEST(LevelText, StaysWhereTheRobotWasWhenItsPosesAreLost) {
  ClearanceMarkers markers(mast());
  const MarkerArray known = markers.draw(clearanceWith({0.0123}), liftedTo(4.0), {});
  const MarkerArray lost = markers.draw(invalidBecause("no transform"), BodyPoses(2), {});
  EXPECT_EQ(find(lost, "level").pose.position.z, find(known, "level").pose.position.z);
}

TEST(LevelText, StandsAboveTheRobotBeforeItsPosesAreKnown) {
  const MarkerArray array = ClearanceMarkers(mast()).draw(invalidBecause("no transform"), BodyPoses(2), {});
  EXPECT_GT(find(array, "level").pose.position.z, 2.0);
}

TEST(WitnessMarkers, AreColouredByTheLevelOfEachPair) {
  const Marker lines = find(draw(clearanceWith({0.01, 0.2})), "witnesses");
  ASSERT_EQ(lines.type, Marker::LINE_LIST);
  ASSERT_EQ(lines.points.size(), 4u);
  ASSERT_EQ(lines.colors.size(), 4u);
  EXPECT_TRUE(isRed(lines.colors[0]));
  EXPECT_TRUE(isGreen(lines.colors[2]));
}

TEST(WitnessMarkers, ShowTheDecidingPairAlsoWhereNoneIsListed) {
  Clearance clearance = clearanceWith({1.2});
  clearance.below_threshold.clear();
  clearance.levels.clear();
  const MarkerArray array = draw(clearance);
  EXPECT_EQ(find(array, "witnesses").points.size(), 2u);
  EXPECT_EQ(find(array, "deciding").points.size(), 2u);
}

TEST(WitnessMarkers, LeaveOutPairsWithoutPoints) {
  Clearance clearance = clearanceWith({0.01, 0.2});
  clearance.deciding.points_valid = false;
  EXPECT_EQ(find(draw(clearance), "witnesses").points.size(), 2u);
}

TEST(DecidingPair, IsDrawnBeforeACloserOneThatHasABetterLevel) {
  Clearance clearance = clearanceWith({0.01, 0.03});
  clearance.deciding = clearance.below_threshold[1];
  clearance.deciding_threshold = 0.04;
  clearance.level = clearance.levels[1] = Clearance::STOP;
  clearance.levels[0] = Clearance::CLEAR;
  const MarkerArray array = draw(clearance);
  EXPECT_EQ(find(array, "deciding").points[1].y, 0.03);
  const Marker lines = find(array, "witnesses");
  ASSERT_EQ(lines.points.size(), 4u);
  EXPECT_EQ(lines.points[1].y, 0.03);
  EXPECT_TRUE(isRed(lines.colors[0]));
  EXPECT_TRUE(isGreen(lines.colors[2]));
}

TEST(DecidingPair, HasAThickLineInTheColourOfTheLevelAndOneToItsText) {
  Clearance clearance = clearanceWith({0.0201});
  clearance.level = Clearance::STOP;  // by the hysteresis: alone the distance would mean WARN
  const MarkerArray array = draw(clearance);
  const Marker line = find(array, "deciding"), leader = find(array, "leaders"), text = find(array, "level");
  ASSERT_EQ(line.points.size(), 2u);
  EXPECT_EQ(line.points[1].y, 0.0201);
  EXPECT_GT(line.scale.x, find(array, "witnesses").scale.x);
  EXPECT_EQ(line.color, text.color);
  ASSERT_EQ(leader.points.size(), 2u);
  EXPECT_EQ(leader.points[0].x, 0.5);
  EXPECT_EQ(leader.points[0].y, 0.01005);
  EXPECT_EQ(leader.colors[1], text.color);
  const double bottom = text.pose.position.z - 1.2 * text.scale.z;
  EXPECT_LT(leader.points[1].z, bottom);
  EXPECT_GT(leader.points[1].z, bottom - text.scale.z);
}

// Regression: labels stood beside the robot, and seen from there in front of it.
TEST(Labels, StandAboveTheRobotAndBelowTheLevelWithALineToTheirPair) {
  Clearance clearance = clearanceWith({0.01, 0.015});
  for (geometry_msgs::Point* end : {&clearance.below_threshold[1].point_a, &clearance.below_threshold[1].point_b})
    end->x = -0.9;
  const MarkerArray array = draw(clearance);
  const Marker label = find(array, "distances"), text = find(array, "level");
  EXPECT_EQ(label.text, "15.0 mm");
  EXPECT_TRUE(isRed(label.color));
  EXPECT_GT(label.pose.position.z - 0.6 * label.scale.z, 2.0);
  EXPECT_LT(label.pose.position.z + 0.6 * label.scale.z, text.pose.position.z - 1.2 * text.scale.z);
  const Marker leaders = find(array, "leaders");
  ASSERT_EQ(leaders.points.size(), 4u);
  EXPECT_EQ(leaders.points[2].x, -0.9);
  EXPECT_EQ(leaders.points[3].x, label.pose.position.x);
  EXPECT_LT(leaders.points[3].z, label.pose.position.z - 0.5 * label.scale.z) << "it strikes the text through";
}

TEST(Labels, AreThoseOfTheFewClosestPairsAndNotOneOverTheOther) {
  Clearance clearance = clearanceWith({0.01, 0.02, 0.03, 0.04, 0.05});
  for (std::size_t i = 1; i < 5; ++i) {
    Proximity& pair = clearance.below_threshold[i];
    pair.point_a.x = pair.point_b.x = -0.9;
  }
  const MarkerArray together = draw(clearance);
  EXPECT_EQ(find(together, "witnesses").points.size(), 10u);
  EXPECT_EQ(find(together, "distances", 0).text, "20.0 mm");
  EXPECT_EQ(find(together, "distances", 1).action, Marker::DELETE);
  EXPECT_EQ(find(together, "leaders").points.size(), 4u);
  // Now the third on the other side.
  clearance.below_threshold[2].point_a.x = clearance.below_threshold[2].point_b.x = 0.9;
  const MarkerArray apart = draw(clearance);
  EXPECT_EQ(find(apart, "distances", 1).text, "30.0 mm");
  EXPECT_LT(find(apart, "distances", 1).scale.z, find(apart, "level").scale.z);
  EXPECT_LE(typesOf(apart)[Marker::TEXT_VIEW_FACING], 3);
}

TEST(Labels, LeaveRoomForTheLineToTheTextOfTheLevel) {
  Clearance clearance = clearanceWith({0.01, 0.015});
  for (geometry_msgs::Point* end : {&clearance.below_threshold[1].point_a, &clearance.below_threshold[1].point_b})
    end->x = end->y = 0.0;
  EXPECT_EQ(find(draw(clearance), "distances").action, Marker::DELETE);
}

TEST(Labels, AreNotOfPairsBesideTheClosestButOfTheNextThatAreElsewhere) {
  Clearance clearance = clearanceWith({0.01, 0.015, 0.03});
  clearance.below_threshold[2].point_a.x = clearance.below_threshold[2].point_b.x = -0.9;
  EXPECT_EQ(find(draw(clearance), "distances").text, "30.0 mm");
}

// Markers that come and go by other names make RViz flicker, and one whose removal was lost stays for ever.
TEST(ClearanceMarkersOfEveryCycle, HaveTheSameNamesAndNumbersAndEndByThemselves) {
  const auto names = [](const MarkerArray& array) {
    std::vector<std::pair<std::string, int>> result;
    for (const Marker& marker : array.markers) {
      result.emplace_back(marker.ns, marker.id);
      EXPECT_GE(marker.lifetime.toSec(), 3.0);
      EXPECT_LE(marker.lifetime.toSec(), 30.0);
    }
    return result;
  };
  const auto many = names(draw(clearanceWith({0.01, 0.02, 0.03, 0.04})));
  EXPECT_EQ(names(draw(clearanceWith({0.5}))), many);
  EXPECT_EQ(names(draw(invalidBecause("no transform"))), many);
  EXPECT_EQ(std::set(many.begin(), many.end()).size(), many.size());
  MonitorSettings slow;
  slow.rate = 0.1;
  EXPECT_GE(draw(clearanceWith({0.5}), 1.0, slow).markers[0].lifetime.toSec(), 20.0);
}

}  // namespace proximity_server::node::markers_test
