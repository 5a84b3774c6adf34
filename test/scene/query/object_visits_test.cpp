#include "scene/query/object_visits.h"

#include "chance.h"
#include "scene/query/cell.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene::object_visits_test {

using namespace narrowphase;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A link at the origin and moving objects, all of them balls of radius 1.
class ObjectsAbout : public testing::Test {
 protected:
  void putAt(const std::vector<Eigen::Vector3d>& places) {
    std::vector<ObjectChange> changes;
    for (std::size_t i = 0; i < places.size(); ++i)
      changes.push_back(add("object" + std::to_string(i), {{Shape(Sphere{1.0})}}, Moving{std::to_string(i)}));
    const auto objects = std::make_shared<const Objects>(Objects(model_).changed(changes));
    robot_.use(objects);
    FramePoses poses;
    for (const std::string& frame : objects->frames())
      poses.emplace_back(Eigen::Isometry3d(Eigen::Translation3d(places[std::stoul(frame)])));
    robot_.update(posesOf(model_->robot, {at(0, 0, 0)}), poses);
    visits_.fit(robot_);
  }

  double gapTo(int object) const { return boxGap(robot_.worldBox(link_), robot_.worldBox(object)); }

  /// Returns a visitor that appends the gap between the boxes of each pair.
  auto into(std::vector<double>& gaps) const {
    return [&](int link, int object) {
      EXPECT_EQ(link, link_);
      gaps.push_back(gapTo(object));
    };
  }

  std::vector<double> allGaps() const {
    std::vector<double> gaps;
    for (const int number : robot_.objects()->numbers()) gaps.push_back(gapTo(robot_.numberOfObject(number)));
    std::sort(gaps.begin(), gaps.end());
    return gaps;
  }

  const std::shared_ptr<const SceneModel> model_ = modelOf(floatingLinks({ball("1")}));
  const int link_ = model_->robot.findLink("0");
  PlacedRobot robot_{model_->robot, std::make_shared<const Volumes>(model_->robot)};
  ObjectVisits visits_;
};

std::vector<Eigen::Vector3d> randomPlaces() {
  Chance chance(1);
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 100; ++i) places.emplace_back(chance.pose(20.0).translation());
  return places;
}

// In space a node may be near and each of its objects far: then another node is opened first.
TEST_F(ObjectsAbout, AreVisitedTheNearestFirst) {
  putAt(randomPlaces());
  std::vector<double> visited;
  visits_.begin(robot_, into(visited));
  EXPECT_TRUE(visited.empty()) << "all are in the tree";
  while (!visits_.empty()) {
    const std::size_t before = visited.size();
    const double bound = visits_.lowestBound();
    visits_.open(robot_, kInfinity, into(visited));
    if (visited.size() == before) continue;
    EXPECT_GE(visited.back(), bound);
    EXPECT_GE(visits_.lowestBound(), visited.back());
  }
  EXPECT_EQ(visited, allGaps());
}

TEST_F(ObjectsAbout, AreLeftOutBeyondTheLimit) {
  putAt(randomPlaces());
  std::vector<double> expected = allGaps();
  const double limit = expected[40];
  expected.resize(41);
  std::vector<double> visited, within;
  visits_.begin(robot_, into(visited));
  while (!visits_.empty()) visits_.open(robot_, limit, into(visited));
  EXPECT_EQ(visited, expected);
  visits_.enterAllWithin(robot_, limit, into(within));
  std::sort(within.begin(), within.end());
  EXPECT_EQ(within, expected);
}

TEST_F(ObjectsAbout, AreNotVisitedOnceMoreAfterAllWithinALimit) {
  putAt(randomPlaces());
  std::vector<double> visited;
  visits_.begin(robot_, into(visited));
  visits_.open(robot_, kInfinity, into(visited));
  EXPECT_FALSE(visits_.empty());
  visits_.enterAllWithin(robot_, allGaps()[40], into(visited));
  EXPECT_TRUE(visits_.empty());
}

}  // namespace proximity_server::scene::object_visits_test
