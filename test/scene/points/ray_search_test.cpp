#include "proximity_server/scene/points/ray_search.h"

#include "proximity_server/scene/points/point_search.h"
#include "scene/files.h"
#include "scene/query/cell.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace proximity_server::scene::ray_search_test {

using Eigen::Vector3d;
using narrowphase::Shape;
using narrowphase::Status;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const ShapeRef kNothing;

RayHit askOne(const State& state, const Ray& ray, const std::vector<ShapeRef>& shapes = {}) {
  return RaySearch(state.sharedModel()).firstHits(state, {ray}, shapes).front();
}

std::string errorOf(const State& state, const Ray& ray) {
  return scene::errorOf([&] { RaySearch(state.sharedModel()).firstHits(state, {{{0, 0, 0}, {1, 0, 0}}, ray}); });
}

void expectHit(const RayHit& hit, double distance, const ShapeRef& shape, const Vector3d& normal) {
  EXPECT_EQ(hit.status, Status::Converged);
  EXPECT_EQ(hit.shape, shape);
  EXPECT_NEAR(hit.distance, distance, 1e-8);
  EXPECT_LE(hit.free, hit.distance);
  EXPECT_GE(hit.free, distance - 1e-6);
  EXPECT_TRUE(hit.normal.isApprox(normal, 1e-6)) << hit.normal.transpose();
}

void expectFree(const RayHit& hit, double range) {
  EXPECT_EQ(hit.status, Status::Converged);
  EXPECT_EQ(hit.shape, kNothing);
  EXPECT_EQ(hit.free, range);
  EXPECT_TRUE(std::isnan(hit.distance));
}

TEST(RaySearch, FindsTheFirstOfSeveralLinks) {
  Cell cell({box("2 4 6"), ball("0.5")});
  cell.put({at(5, 0, 0), at(2, 0, 0)});
  const State& state = cell.scene().state;
  const ShapeRef of_box = cell.link("0").part(1), of_ball = cell.link("1").part(1);
  expectHit(askOne(state, {{0, 0, 0}, {2, 0, 0}}), 1.5, of_ball, -Vector3d::UnitX());
  expectHit(askOne(state, {{0, 1, 0}, {2, 0, 0}}), 4.0, of_box, -Vector3d::UnitX());
  expectHit(askOne(state, {{9, 0, 0}, {-1, 0, 0}}), 3.0, of_box, Vector3d::UnitX());
  expectHit(askOne(state, {{0, 0, 0}, {1, 0, 0}}, {cell.link("0")}), 4.0, of_box, -Vector3d::UnitX());
  expectFree(askOne(state, {{0, 0, 0}, {-1, 0, 0}}), kInfinity);
  expectFree(askOne(state, {{0, 0, 0}, {1, 0, 0}, 1.25}), 1.25);
  expectFree(askOne(state, {{0, 0.6, 0}, {1, 0, 0}, 3.75}), 3.75);
}

TEST(RaySearch, HitsAtZeroFromWithin) {
  Meshes meshes;
  Cell cell({box("2 4 6"), meshes.of(bracket())});
  cell.put({at(5, 0, 0), at(-5, 0, 0)});
  const RayHit of_box = askOne(cell.scene().state, {{5, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(of_box.distance, 0.0);
  EXPECT_EQ(of_box.free, 0.0);
  EXPECT_EQ(of_box.shape, cell.link("0").part(1));
  const RayHit of_interior = askOne(cell.scene().state, {{-4.5, 0.5, 0.4}, {1, 0, 0}});
  EXPECT_EQ(of_interior.distance, 0.0);
  EXPECT_EQ(of_interior.shape, cell.link("1").part(1));
  EXPECT_NEAR(of_interior.normal.norm(), 1.0, 1e-12);
}

TEST(RaySearch, MeetsObjectsAndHalfSpaces) {
  Cell cell({ball("0.5")});
  cell.change(
      {add("floor", {{HalfSpace{{0, 0, 1}, 0.0}}}, Fixed{at(0, 0, -1)}),
       add("things", {{Shape(narrowphase::Box{{1, 1, 1}})}, {Shape(narrowphase::Sphere{0.5})}}, Fixed{at(4, 0, 0)})});
  cell.put({at(50, 0, 0)});
  const State& state = cell.scene().state;
  expectHit(askOne(state, {{0, 0, 0}, {3, 0, -4}}), 1.25, cell.object("floor").part(1), Vector3d::UnitZ());
  expectHit(askOne(state, {{0, 0, 0}, {1, 0, 0}}), 3.5, cell.object("things").part(1), -Vector3d::UnitX());
  EXPECT_EQ(askOne(state, {{0, 0, -2}, {1, 0, 0}}).distance, 0.0);
  expectFree(askOne(state, {{0, 0, 0}, {0, 1, 0}}), kInfinity);
  expectFree(askOne(state, {{0, 0, 0}, {0, 0, -1}, 0.75}), 0.75);
}

// At the distance of the hit, the point of the ray has the distance 0 from the shapes. All points before it are outside.
TEST(RaySearch, AgreesWithTheDistancesOfPointsAlongTheRay) {
  Meshes meshes;
  Cell cell({box("0.4 0.6 0.8"), meshes.of(bracket()),
             "<collision><geometry><cylinder radius='0.3' length='0.7'/>"
             "</geometry></collision>"});
  Chance chance(29);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    cell.put({chance.pose(1.0), chance.pose(1.0), chance.pose(1.0)});
    const State& state = cell.scene().state;
    Ray ray{3.0 * chance.direction(), {}, 6.0};
    ray.direction = 0.7 * chance.direction() - ray.origin;
    const RayHit hit = askOne(state, ray);
    EXPECT_EQ(hit.status, Status::Converged);
    const bool is_hit = hit.shape != kNothing;
    const double end = is_hit ? hit.distance : ray.range;
    Points points;
    const Vector3d direction = ray.direction.normalized();
    for (int k = 0; k <= 50; ++k) points.centres.push_back(ray.origin + (end * k / 50.0) * direction);
    PointSearch search(state.sharedModel());
    const auto& found = search.closest(state, points);
    for (int k = 0; k < 50; ++k) EXPECT_GT(found[k].result.upper_bound, 0.0) << i << " " << k;
    if (is_hit) {
      EXPECT_NEAR(found[50].result.distance, 0.0, 2e-9);
    } else {
      EXPECT_GT(found[50].result.upper_bound, 0.0);
    }
    hits += is_hit;
  }
  EXPECT_GT(hits, 50);
  EXPECT_LT(hits, 250);
}

TEST(RaySearch, HasTheSameBitsAloneAndAmongOthers) {
  Meshes meshes;
  Cell cell({box("0.4 0.6 0.8"), meshes.of(bracket())});
  Chance chance(31);
  cell.put({chance.pose(1.0), chance.pose(1.0)});
  const State& state = cell.scene().state;
  std::vector<Ray> rays;
  for (int i = 0; i < 200; ++i)
    rays.push_back({2.0 * chance.direction(), chance.direction(), chance.between(1.0, 4.0)});
  RaySearch search(state.sharedModel());
  const std::vector<RayHit> together = search.firstHits(state, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const RayHit alone = search.firstHits(state, {rays[i]}).front();
    EXPECT_EQ(together[i].shape, alone.shape);
    EXPECT_EQ(together[i].free, alone.free);
    if (alone.shape != kNothing) {
      EXPECT_EQ(together[i].distance, alone.distance);
    }
  }
}

TEST(RaySearch, LeavesOutShapesWithoutAPose) {
  Cell cell({box("2 2 2")});
  RaySearch search(cell.scene().state.sharedModel());
  expectFree(search.firstHits(cell.scene().state, {{{5, 0, 0}, {-1, 0, 0}, 9.0}}).front(), 9.0);
  ASSERT_EQ(search.unplaced().size(), 1u);
  EXPECT_EQ(search.unplaced()[0], cell.link("0"));
}

TEST(RaySearch, NamesWhatItRefuses) {
  Cell cell({box("2 2 2")});
  cell.put({at(5, 0, 0)});
  const State& state = cell.scene().state;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(errorOf(state, {{nan, 0, 0}, {1, 0, 0}}), "origins[1] is not finite");
  EXPECT_EQ(errorOf(state, {{0, 0, 0}, {0, 0, 0}}), "directions[1] is not finite, or has no length");
  EXPECT_EQ(errorOf(state, {{0, 0, 0}, {1, 0, 0}, 0.0}), "ranges[1] is not positive");
  EXPECT_EQ(errorOf(state, {{0, 0, 0}, {1, 0, 0}, nan}), "ranges[1] is not positive");
  EXPECT_THROW(RaySearch(nullptr), std::invalid_argument);
}

}  // namespace proximity_server::scene::ray_search_test
