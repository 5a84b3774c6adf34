#include "tools/sweep/sweep_summary.h"

#include "proximity_server/scene/loading/load_robot_model.h"
#include "scene/files.h"
#include "tools/robot/two_sliders.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace proximity_server::tools::sweep_summary_test {

const scene::RobotModel& robot() {
  static const scene::RobotModel model = scene::loadRobotModel(kTwoSliders, scene::packageResolver({}));
  return model;
}

SweepSummary::Names namesOf(std::size_t pair) { return {"a" + std::to_string(pair), "b"}; }

NumberedPair stateAt(std::uint64_t state, double distance) {
  return {state, static_cast<int>(state % 3), distance, distance - 1e-9, distance + 1e-9};
}

auto namesIn(std::size_t pair) {
  return [pair] { return namesOf(pair); };
}

SweepSummary summaryOf(const std::vector<double>& distances, std::size_t begin, std::size_t end) {
  SummaryCounter counter(SummaryKind::Distances);
  for (std::size_t i = begin; i < end; ++i)
    counter.add(stateAt(i, distances[i]), namesIn(i % 3), [&] { return scene::Positions{distances[i], 0.0}; });
  return counter.summary(robot(), namesOf);
}

TEST(SweepSummary, ABinHasItsLowerBorder) {
  // n / 100 as a double, and its neighbours: the product with 100 is rounded to the wrong side for some of them.
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (int n = -1000; n <= 999; ++n) {
    const double border = n / 100.0;
    EXPECT_EQ(SummaryCounter::binOf(border), n);
    EXPECT_EQ(SummaryCounter::binOf(std::nextafter(border, kInfinity)), n);
    EXPECT_EQ(SummaryCounter::binOf(std::nextafter(border, -kInfinity)), n - 1);
  }
  EXPECT_EQ(SummaryCounter::binOf(10.0), 1000);
  EXPECT_EQ(SummaryCounter::binOf(kInfinity), 1000);
  EXPECT_EQ(SummaryCounter::binOf(-kInfinity), -1001);
}

TEST(SweepSummary, CountsStatesByDistanceAndPair) {
  SummaryCounter counter(SummaryKind::Distances);
  const auto positions = [] {
    scene::Positions all(robot().joints.size(), 1.0);
    all[robot().joints[0].name == "slide" ? 0 : 1] = 0.5;
    return all;
  };
  counter.add({0, 1, 0.025, 0.02, 0.03}, namesIn(1), positions);
  counter.add({1, 1, 0.021, 0.02, 0.03}, namesIn(1), positions);
  counter.add({2, 0, 0.001, -0.001, 0.002}, namesIn(0), positions);  // not proven to be apart
  counter.add({3, -1, -0.005, -0.005, -0.005}, namesIn(1), positions);
  counter.addUnknown();
  counter.addUnlisted();
  const nlohmann::ordered_json json = counter.summary(robot(), namesOf).toJson();
  EXPECT_EQ(json["states"], 6);
  EXPECT_EQ(json["unknown"], 1);
  EXPECT_EQ(json["unlisted"], 1);
  EXPECT_EQ(json["at_or_below_0"], 2);
  EXPECT_EQ(json["histogram"].dump(),
            R"([{"from":-0.01,"states":1},{"from":0.0,"states":1},{"from":0.02,"states":2}])");
  EXPECT_EQ(json["pairs"].dump(),
            R"([{"link_a":"a1","link_b":"b","states":3},{"link_a":"a0","link_b":"b","states":1}])");
  EXPECT_EQ(json["worst"][0].dump(), R"({"state":3,"link_a":"a1","link_b":"b","distance":-0.005,"lower":-0.005,)"
                                     R"("upper":-0.005,"positions":{"slide":0.5}})");
  EXPECT_EQ(json["worst"].size(), 4U);
}

TEST(SweepSummary, OfVerdictsKeepsTheFirstStatesBelow) {
  SummaryCounter counter(SummaryKind::Verdicts);
  for (std::uint64_t state = 100; state-- > 0;) {
    if (state % 2 == 0) {
      counter.addUnlisted();
    } else {
      counter.add({state, 0}, namesIn(0), [] { return scene::Positions{0.0, 0.0}; });
    }
  }
  const nlohmann::ordered_json json = counter.summary(robot(), namesOf).toJson();
  EXPECT_EQ(json["above"], 50);
  EXPECT_EQ(json["below"], 50);
  ASSERT_EQ(json["first_below"].size(), SweepSummary::kNotable);
  EXPECT_EQ(json["first_below"][9]["state"], 19);
  EXPECT_FALSE(json["first_below"][0].contains("distance"));
}

TEST(SweepSummary, OfMergedPartsHasTheBytesOfTheWhole) {
  std::mt19937 random(3);
  std::vector<double> distances(2000);
  // Few values, so that the worst states have many equals.
  for (double& distance : distances) distance = std::uniform_int_distribution<int>(-20, 400)(random) / 64.0;
  const std::string whole = summaryOf(distances, 0, distances.size()).toJson().dump();
  for (int repeat = 0; repeat < 50; ++repeat) {
    std::vector<std::size_t> borders{0, distances.size()};
    for (int i = 0; i < 7; ++i) borders.push_back(std::uniform_int_distribution<std::size_t>(0, 2000)(random));
    std::sort(borders.begin(), borders.end());
    SweepSummary merged;
    for (std::size_t i = 0; i + 1 < borders.size(); ++i)  // as merging does: through the text of the manifests
      merged.add(SweepSummary::fromJson(
          nlohmann::ordered_json::parse(summaryOf(distances, borders[i], borders[i + 1]).toJson().dump())));
    EXPECT_EQ(merged.toJson().dump(), whole);
  }
}

TEST(SweepSummary, RefusesOtherJson) {
  EXPECT_NE(scene::errorOf([] {
              SweepSummary::fromJson(nlohmann::ordered_json::parse("{\"states\": 3}"));
            }).find("no summary of a sweep"),
            std::string::npos);
}

}  // namespace proximity_server::tools::sweep_summary_test
