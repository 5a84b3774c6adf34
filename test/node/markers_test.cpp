#include "markers.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace proximity_server {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

/// A robot of one link with this geometry.
RobotModel robotOf(const std::string& geometry) {
  return loadRobotModel("<robot name='r'><link name='l'>" + geometry + "</link></robot>", packageResolver({}));
}

std::map<int, int> typesOf(const MarkerArray& array) {
  std::map<int, int> count;
  for (const Marker& marker : array.markers) ++count[marker.type];
  return count;
}

Clearance clearanceWith(const std::vector<double>& distances) {
  Clearance clearance;
  clearance.header.frame_id = "base";
  for (const double distance : distances) {
    Proximity pair;
    pair.distance = distance;
    pair.points_valid = true;
    pair.point_b.x = distance;
    clearance.below_threshold.push_back(pair);
  }
  return clearance;
}

TEST(PieceMarkers, OfPrimitivesHaveTheirSizeAndPlace) {
  const MarkerArray array = pieceMarkers(
      robotOf("<collision><origin xyz='1 2 3'/><geometry><box size='0.1 0.2 0.3'/></geometry></collision>"), "");
  ASSERT_EQ(array.markers.size(), 1u);
  const Marker& box = array.markers[0];
  EXPECT_EQ(box.type, Marker::CUBE);
  EXPECT_EQ(box.header.frame_id, "l");
  EXPECT_NEAR(box.scale.y, 0.2, 1e-15);
  EXPECT_NEAR(box.pose.position.z, 3.0, 1e-15);
}

TEST(PieceMarkers, OfACapsuleAreACylinderAndTwoBalls) {
  const std::string ball = "<collision><origin xyz='0 0 %'/><geometry><sphere radius='0.1'/></geometry></collision>";
  const auto at = [&](const std::string& z) { return std::string(ball).replace(ball.find('%'), 1, z); };
  const MarkerArray array =
      pieceMarkers(robotOf("<collision><geometry><cylinder radius='0.1' length='0.4'/></geometry></collision>" +
                           at("0.2") + at("-0.2")),
                   "");
  EXPECT_EQ(typesOf(array), (std::map<int, int>{{Marker::CYLINDER, 1}, {Marker::SPHERE, 2}}));
}

TEST(WitnessMarkers, AreColouredByTheLevelOfEachPair) {
  const MarkerArray array = witnessMarkers(clearanceWith({0.01, 0.2}), MonitorSettings(), 0);
  const Marker& lines = array.markers.back();
  ASSERT_EQ(lines.type, Marker::LINE_LIST);
  ASSERT_EQ(lines.points.size(), 4u);
  ASSERT_EQ(lines.colors.size(), 4u);
  EXPECT_GT(lines.colors[0].r, lines.colors[0].g);  // STOP is red
  EXPECT_GT(lines.colors[2].g, lines.colors[2].r);  // CLEAR is green
}

TEST(WitnessMarkers, TakeAwayWhatIsNoLongerListed) {
  const MarkerArray array = witnessMarkers(clearanceWith({}), MonitorSettings(), 2);
  ASSERT_EQ(array.markers.size(), 3u);  // two labels and the lines
  for (const Marker& marker : array.markers) EXPECT_EQ(marker.action, Marker::DELETE);
}

}  // namespace
}  // namespace proximity_server
