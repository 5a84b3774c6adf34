#include "proximity_server/scene/points/self_filter.h"

#include "chance.h"
#include "proximity_server/scene/points/point_search.h"
#include "scene/query/cell.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene::self_filter_test {

using Eigen::Vector3d;
using Cloud = std::vector<Vector3d>;

/// A box, triangles of a bracket, and a ball with a box; a link holds a box, and there is a wall.
struct SeenRobot : Cell {
  explicit SeenRobot(Meshes& meshes)
      : Cell({box("0.4 0.6 0.8"), meshes.of(bracket()), ball("0.3") + box("0.1 0.2 0.3", "0.5 0 0")}) {
    change({add("held", {{narrowphase::Shape(narrowphase::Box{{0.2, 0.2, 0.2}})}}, Attached{"2", {}, at(0, 0.8, 0)}),
            add("wall", {{narrowphase::Shape(narrowphase::Box{{0.1, 9, 9}})}}, Fixed{at(1, 0, 0)})});
  }
  void putAtChance(Chance& chance) { put({chance.pose(1.0), chance.pose(1.0), chance.pose(1.0)}); }
  const State& state() { return scene().state; }

  /// The points that are not within the padding of a shape, each asked about alone, without voxels and skipping.
  Cloud keptOneByOne(const SelfPadding& padding, const Cloud& cloud) {
    PointSearch search(state().sharedModel(), Skipping::Off);
    Cloud kept;
    for (const Vector3d& point : cloud) {
      bool is_on_robot = false;
      for (const ShapeRef& shape : shapesOfRobot(robot(), *objects())) {
        const auto own = padding.of_links.find(shape.isLink() ? shape.link() : link("2").link());
        const double distance = search.closest(state(), {{point}, {}, {shape}}).front().result.distance;
        is_on_robot |= distance <= (own == padding.of_links.end() ? padding.of_all : own->second);
      }
      if (!is_on_robot) kept.push_back(point);
    }
    return kept;
  }
};

Cloud randomCloud(Chance& chance, int points) {
  Cloud cloud;
  for (int i = 0; i < points; ++i) cloud.push_back(chance.pose(chance.happens(0.5) ? 1.5 : 0.6).translation());
  return cloud;
}

TEST(SelfFilter, RemovesWhatEachPointAloneTells) {
  Meshes meshes;
  SeenRobot robot(meshes);
  Chance chance(3);
  std::size_t removed_in_all = 0;
  for (const double resolution : {0.01, 0.05, 0.4}) {
    SelfFilter filter(robot.state().sharedModel(), resolution);
    for (const SelfPadding& padding : {SelfPadding{0.0}, SelfPadding{0.05}, SelfPadding{0.02, {{1, 0.1}, {2, 0.0}}}}) {
      robot.putAtChance(chance);
      const Cloud cloud = randomCloud(chance, 400);
      Cloud filtered = cloud;
      const std::size_t removed = filter.remove(robot.state(), padding, filtered);
      EXPECT_EQ(filtered, robot.keptOneByOne(padding, cloud)) << "resolution " << resolution;
      EXPECT_EQ(removed + filtered.size(), cloud.size());
      removed_in_all += removed;
    }
  }
  EXPECT_GT(removed_in_all, 300U) << "the clouds are beside the robot";
}

TEST(SelfFilter, EndsAtThePadding) {
  Cell cell({ball("0.3"), ball("0.2")});
  cell.put({at(0, 0, 0), at(2, 0, 0)});
  const Cloud within{{0.3499999, 0, 0}, {0, -0.3499999, 0}, {0.1, 0, 0}, {2.2999999, 0, 0}},
      beyond{{0.3500001, 0, 0}, {0, -0.3500001, 0}, {2, 0, 0.3000001}};
  for (const double resolution : {0.002, 0.02}) {
    SelfFilter filter(cell.scene().state.sharedModel(), resolution);
    Cloud cloud = beyond;
    cloud.insert(cloud.begin() + 1, within.begin(), within.end());
    EXPECT_EQ(filter.remove(cell.scene().state, {0.05, {{cell.link("1").link(), 0.1}}}, cloud), 4U);
    EXPECT_EQ(cloud, beyond);
  }
}

TEST(SelfFilter, KeepsTheCloudIfItCannotTell) {
  Meshes meshes;
  SeenRobot robot(meshes);
  const auto errorOf = [&](const SelfPadding& padding, Cloud cloud, const Question& question = {}) -> std::string {
    const Cloud before = cloud;
    SelfFilter filter(robot.state().sharedModel(), 0.02);
    try {
      filter.remove(robot.state(), padding, cloud, question);
      return "";
    } catch (const std::exception& error) {
      EXPECT_EQ(cloud, before);
      return error.what();
    }
  };
  const Cloud cloud{{0, 0, 0}};
  Chance chance(4);
  robot.putAtChance(chance);
  EXPECT_EQ(errorOf({0.1}, cloud), "");
  EXPECT_EQ(errorOf({-0.1}, cloud), "the padding of 0 is negative or not finite");
  EXPECT_EQ(errorOf({0.1, {{robot.link("1").link(), -1e-9}}}, cloud), "the padding of 1 is negative or not finite");
  EXPECT_EQ(errorOf({0.1}, {{0, 0, 0}, {0, 1e300, 0}}),
            "a point is not finite, or too far for the resolution of its voxels");
  Question over;
  over.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  EXPECT_EQ(errorOf({0.1}, cloud, over), "the time for the self filter is over");
  BodyPoses poses = robot.state().poses();
  poses[robot.robot().links[robot.link("1").link()].body].reset();
  robot.scene().update(poses);
  EXPECT_EQ(errorOf({0.1}, cloud), "1 has no pose");
}

}  // namespace proximity_server::scene::self_filter_test
