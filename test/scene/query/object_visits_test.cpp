#include "scene/query/object_visits.h"

#include "scene/query/cell.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene::object_visits_test {

using namespace narrowphase;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Places = std::vector<double>;

/// A link at the origin and moving objects on the x axis, all of them balls of radius 1.
class ObjectsOnALine : public testing::Test {
 protected:
  void putAt(const Places& places) {
    std::vector<ObjectChange> changes;
    for (std::size_t i = 0; i < places.size(); ++i)
      changes.push_back(add("object" + std::to_string(i), {{Shape(Sphere{1.0})}}, Moving{std::to_string(i)}));
    const auto objects = std::make_shared<const Objects>(Objects(model_).changed(changes));
    robot_.use(objects);
    robot_.update(posesOf(model_->robot, {at(0, 0, 0)}));
    FramePoses poses;
    for (const std::string& frame : objects->frames()) poses.emplace_back(at(places[std::stoul(frame)], 0, 0));
    robot_.updateFrames(poses);
    visits_.fit(robot_);
  }

  /// Returns a visitor that appends the x coordinate of the object of each pair.
  auto into(Places& visited) const {
    return [&](int link, int object) {
      EXPECT_EQ(link, model_->robot.findLink("0"));
      visited.push_back(std::round(robot_.worldBox(object).center().x()));
    };
  }

  const std::shared_ptr<const SceneModel> model_ = modelOf(floatingLinks({ball("1")}));
  PlacedRobot robot_{model_->robot, std::make_shared<const Volumes>(model_->robot)};
  ObjectVisits visits_;
};

TEST_F(ObjectsOnALine, AreVisitedTheNearestFirst) {
  putAt({9.0, 3.0, 6.0, -4.0});
  Places visited;
  visits_.begin(robot_, kInfinity, into(visited));
  EXPECT_TRUE(visited.empty()) << "all are in the tree";
  for (const double gap : {1.0, 2.0, 4.0, 7.0}) {
    ASSERT_FALSE(visits_.empty());
    const std::size_t before = visited.size();
    while (visited.size() == before) visits_.open(robot_, kInfinity, into(visited));
    EXPECT_NEAR(std::abs(visited.back()) - 2.0, gap, 1e-12);
    EXPECT_GE(visits_.lowestBound(), gap);
  }
  EXPECT_EQ(visited, (Places{3.0, -4.0, 6.0, 9.0}));
  EXPECT_TRUE(visits_.empty());
}

TEST_F(ObjectsOnALine, AreLeftOutBeyondTheLimit) {
  putAt({9.0, 3.0, 6.0, -4.0});
  Places visited, within;
  visits_.begin(robot_, 3.0, into(visited));
  while (!visits_.empty()) visits_.open(robot_, 3.0, into(visited));
  EXPECT_EQ(visited, (Places{3.0, -4.0}));
  visits_.enterAllWithin(robot_, 3.0, into(within));
  std::sort(within.begin(), within.end());
  EXPECT_EQ(within, (Places{-4.0, 3.0}));
}

}  // namespace proximity_server::scene::object_visits_test
