// The executable with --trajectory from end to end, on robots whose motions are worked out on paper.
#include "tools/program/clearance_command.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <map>
#include <random>

namespace proximity_server::tools::clearance_trajectory_test {

using namespace narrowphase;

constexpr double kTolerance = 1e-6;  // [m] the default
using Row = std::map<std::string, std::string>;

class ClearanceTrajectory : public Clearance {
 protected:
  /// The rows by the names of their columns.
  std::vector<Row> segments(const std::string& states, const std::string& arguments) {
    const CommandResult result = run(states, "--trajectory " + arguments);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    const auto rows = rowsOf(result.output);
    std::vector<Row> named;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      EXPECT_EQ(rows[i].size(), rows[0].size());
      for (std::size_t k = 0; k < rows[i].size(); ++k) {
        if (k == 0) named.emplace_back();
        named.back()[rows[0].at(k)] = rows[i][k];
      }
    }
    return named;
  }
};

double number(const Row& row, const std::string& column) { return std::stod(row.at(column)); }

// The rod turns its edge to the tip: a square of 0.2 whose corner passes below a sphere of radius 0.25, 1 above its
// axis. After a turn by phi from there the corner is sqrt(1 + r^2 - 2 r cos(phi)) from the centre, r = sqrt(0.02).
constexpr const char* kEdgePasses = "time,spin,approach\n10,0,2\n14,1.5707963267948966,2\n";
const double kCorner = std::sqrt(0.02);

TEST_F(ClearanceTrajectory, WritesTheClosestPairOfEachSegment) {
  // sled - ball, as neighbours are left out: 2.25 + slide apart.
  const std::string states = "slide\n0\n0.5\n-0.5\n";
  EXPECT_EQ(rowsOf(run(states, "--trajectory").output)[0],
            (std::vector<std::string>{"segment",   "t_begin",   "t_end",     "t_minimum",      "link_a",
                                      "link_b",    "distance",  "lower",     "upper",          "point_a_x",
                                      "point_a_y", "point_a_z", "point_b_x", "point_b_y",      "point_b_z",
                                      "normal_x",  "normal_y",  "normal_z",  "status",         "representation",
                                      "contact",   "t_free",    "t_contact", "contact_link_a", "contact_link_b"}));
  const std::vector<Row> rows = segments(states, "");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("segment") + rows[1].at("segment"), "01");
  EXPECT_NEAR(number(rows[0], "distance"), 2.25, kTolerance);
  EXPECT_NEAR(number(rows[1], "distance"), 1.75, kTolerance);
  EXPECT_NEAR(number(rows[0], "t_minimum"), 0.0, kTolerance);
  EXPECT_NEAR(number(rows[1], "t_minimum"), 2.0, kTolerance);
  EXPECT_EQ(rows[1].at("status") + " " + rows[1].at("representation"), "converged exact");
}

TEST_F(ClearanceTrajectory, SaysThatThereIsNoContact) {
  const std::vector<Row> rows = segments("slide\n0\n0.5\n-0.5\n", "");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1].at("contact"), "false");
  EXPECT_EQ(rows[1].at("t_free"), "2");
  EXPECT_EQ(rows[1].at("t_contact"), "nan");
  EXPECT_EQ(rows[1].at("contact_link_a"), "");
}

// base - sled are 1 + slide apart: 0 at half of the way from 0 to -2, 0.25 at 3/8 of it.
TEST_F(ClearanceTrajectory, FindsTheFirstContactOnTheTrajectorysClock) {
  const std::string states = "time,slide\n10,0\n14,-2\n";
  const auto expectContact = [&](const std::string& arguments, double time) {
    const std::vector<Row> rows = segments(states, "--no-filter " + arguments);
    ASSERT_EQ(rows.size(), 1U);
    EXPECT_EQ(rows[0].at("contact"), "true");
    EXPECT_EQ(rows[0].at("contact_link_a") + "|" + rows[0].at("contact_link_b"), "base|sled, left");
    EXPECT_LE(number(rows[0], "t_free"), time);
    EXPECT_NEAR(number(rows[0], "t_free"), time, 1e-4);
    EXPECT_NEAR(number(rows[0], "t_contact"), time, 4.0 * kTolerance);
  };
  expectContact("", 12.0);
  expectContact("--contact-distance 0.25", 11.5);
  expectContact("--contact-distance 1.5", 10.0);
}

TEST_F(ClearanceTrajectory, FindsWhatLiesBetweenTheWayPoints) {
  const std::vector<Row> rows = segments(kEdgePasses, crossingSliders());
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("link_a") + " " + rows[0].at("link_b"), "tip rod");
  EXPECT_LE(number(rows[0], "lower"), 0.75 - kCorner);
  EXPECT_GE(number(rows[0], "upper"), 0.75 - kCorner - 1e-9);
  EXPECT_LE(number(rows[0], "upper") - number(rows[0], "lower"), kTolerance);
  EXPECT_NEAR(number(rows[0], "t_minimum"), 12.0, 0.02);  // 1e-6 m above the minimum is 3 mrad away
  EXPECT_EQ(rows[0].at("contact"), "false");
}

TEST_F(ClearanceTrajectory, FindsAContactBetweenTheWayPoints) {
  const double clearance = 0.62;  // at the way points it is 0.65
  const double phi = std::acos((1.0 + 0.02 - std::pow(clearance + 0.25, 2)) / (2.0 * kCorner));
  const double time = 10.0 + 4.0 * (0.5 - phi / (M_PI / 2.0));
  const std::vector<Row> rows = segments(kEdgePasses, crossingSliders() + " --contact-distance 0.62");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("contact"), "true");
  EXPECT_LE(number(rows[0], "t_free"), time);
  EXPECT_NEAR(number(rows[0], "t_contact"), time, 1e-4);  // the corner comes closer by 0.023 m a second
}

// The ball, at twice the position, is nowhere: neither free nor in contact.
TEST_F(ClearanceTrajectory, SaysWhereNothingIsKnown) {
  const std::vector<Row> rows = segments("slide\n1e308\n1e308\n", "");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("status"), "unknown");
  EXPECT_EQ(rows[0].at("contact"), "unknown");
}

TEST_F(ClearanceTrajectory, SaysWhatItCouldNotDecide) {
  const std::vector<Row> rows =
      segments("spin,approach\n0,1.9\n1e5,2\n", crossingSliders() + " --contact-distance 0.65");  // 16,000 turns
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("status"), "iteration_limit");
  EXPECT_EQ(rows[0].at("contact"), "unknown");
  EXPECT_LT(number(rows[0], "lower"), 0.75 - kCorner);
  EXPECT_GT(number(rows[0], "upper"), 0.75 - kCorner);
}

TEST_F(ClearanceTrajectory, ToleranceSaysHowCloseTheBoundsAre) {
  const std::vector<Row> rows = segments(kEdgePasses, crossingSliders() + " --tolerance 0.01");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_LE(number(rows[0], "lower"), 0.75 - kCorner);
  EXPECT_GE(number(rows[0], "upper"), 0.75 - kCorner - 1e-9);
  EXPECT_LE(number(rows[0], "upper") - number(rows[0], "lower"), 0.01);
}

TEST_F(ClearanceTrajectory, NoStateIsCloserThanTheBoundOfItsSegment) {
  constexpr int kSegments = 25, kStates = 40;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> slide(-1.0, 2.0), spin(-6.0, 6.0), approach(2.0, 2.2);
  std::string way_points = "slide,spin,approach\n", states = way_points;
  std::vector<std::array<double, 3>> path;
  for (int i = 0; i <= kSegments; ++i) path.push_back({slide(random), spin(random), approach(random)});
  const auto line = [&](int segment, double t) {
    std::string text;
    for (std::size_t k = 0; k < 3; ++k) {
      const double from = path[segment][k], to = path[std::min(segment + 1, kSegments)][k];
      text += (k == 0 ? "" : ",") + shortest(from + t * (to - from));
    }
    return text + "\n";
  };
  for (int i = 0; i <= kSegments; ++i) way_points += line(i, 0.0);
  for (int i = 0; i < kSegments * kStates; ++i) states += line(i / kStates, (i % kStates) / (kStates - 1.0));

  const std::string arguments = crossingSliders();
  const std::vector<Row> rows = segments(way_points, arguments);
  const auto sampled = rowsOf(run(states, arguments).output);
  ASSERT_EQ(rows.size(), std::size_t{kSegments});
  ASSERT_EQ(sampled.size(), 1U + kSegments * kStates);
  int missed = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < kStates; ++k) {
      smallest = std::min(smallest, std::stod(sampled[1 + i * kStates + k][3]));
    }
    EXPECT_GE(smallest, number(rows[i], "lower") - 1e-9);
    EXPECT_LE(number(rows[i], "upper"), smallest + kTolerance);
    missed += smallest - number(rows[i], "upper") > 1e-5 ? 1 : 0;
  }
  EXPECT_GT(missed, 10) << "segments in which sampling misses the minimum";
}

TEST_F(ClearanceTrajectory, JsonSaysTheSameAsCsv) {
  const std::string states = "time,slide\n10,0\n14,-2\n15,2\n16,1\n";
  const auto json = nlohmann::json::parse(run(states, "--trajectory --no-filter --format json").output);
  const std::vector<Row> rows = segments(states, "--no-filter");
  ASSERT_EQ(json.size(), 3U);
  ASSERT_EQ(rows.size(), 3U);
  for (std::size_t i = 0; i < json.size(); ++i) {
    EXPECT_EQ(json[i].size(), rows[i].size() + 1) << "contact_state";
    for (const auto& [name, text] : rows[i]) {
      const nlohmann::json& value = json[i].at(name);
      const std::string shown = value.is_string() ? value.get<std::string>() : value.is_null() ? "nan" : value.dump();
      if (value.is_number_float()) {
        EXPECT_EQ(value.get<double>(), std::stod(text)) << name;
      } else {
        EXPECT_EQ(shown, text) << name;
      }
    }
  }
  EXPECT_EQ(json[0]["contact"], true);
  EXPECT_EQ(json[2]["contact"], false);
  EXPECT_TRUE(json[2]["contact_state"].is_null());
}

TEST_F(ClearanceTrajectory, TheStateAtContactIsOne) {
  const std::string arguments = crossingSliders();
  const auto json =
      nlohmann::json::parse(run(kEdgePasses, arguments + " --trajectory --contact-distance 0.62 --format json").output);
  std::string names, positions;
  for (const auto& [name, position] : json.at(0).at("contact_state").items()) {
    names += (names.empty() ? "" : ",") + name;
    positions += (positions.empty() ? "" : ",") + shortest(position.get<double>());
  }
  EXPECT_EQ(names, "approach,reach,slide,spin");
  const auto rows = rowsOf(run(names + "\n" + positions + "\n", arguments).output);
  EXPECT_NEAR(std::stod(rows.at(1).at(3)), 0.62, 2.0 * kTolerance);
}

TEST_F(ClearanceTrajectory, SaysTheSameForAnyNumberOfThreads) {
  const std::string states = wander(200);
  const CommandResult alone = run(states, "--trajectory --no-filter --threads 1");
  EXPECT_EQ(rowsOf(alone.output).size(), 200U);
  EXPECT_EQ(run(states, "--trajectory --no-filter --threads 3").output, alone.output);
}

TEST_F(ClearanceTrajectory, WritesTheSegmentsBeforeAnError) {
  const CommandResult result = run("slide\n0\n1\nnan\n", "--trajectory");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(rowsOf(result.output).size(), 2U);
  EXPECT_TRUE(says(result.errors, "s.csv, line 4: column \"slide\": \"nan\" is no finite number")) << result.errors;
}

TEST_F(Clearance, WarnsOfTimesThatAreNotUsed) {
  const std::string warning = "column \"time\" is not used without --trajectory.\n";
  const CommandResult result = run("time,slide\n3,0\n1,1\n", "");
  EXPECT_TRUE(says(result.errors, warning)) << result.errors;
  EXPECT_EQ(result.output, run("slide\n0\n1\n", "").output);
  const CommandResult trajectory = run("time,slide\n0,0\n1,1\n", "--trajectory");
  EXPECT_FALSE(says(trajectory.errors, "\"time\"")) << trajectory.errors;
  EXPECT_EQ(trajectory.output, run("slide\n0\n1\n", "--trajectory").output);
}

// --- splines. The slider is at 0 at both way points, and at -v t (1 - t / 2) in between: 2.25 - v / 2 apart after 1 s.

std::string swing(double v) {
  return "time,slide,slide.velocity,slide.acceleration\n0,0," + shortest(-v) + "," + shortest(v) + "\n2,0," +
         shortest(v) + "," + shortest(v) + "\n";
}

TEST_F(ClearanceTrajectory, SplinesAreFollowedWhereTheyOvershoot) {
  EXPECT_NEAR(number(segments(swing(1.0), "").at(0), "lower"), 2.25, kTolerance);
  for (const std::string how : {"cubic", "quintic"}) {
    const Row row = segments(swing(1.0), "--interpolation " + how + " --contact-distance 2").at(0);
    EXPECT_LE(number(row, "lower"), 1.75) << how;
    EXPECT_NEAR(number(row, "lower"), 1.75, kTolerance) << how;
    EXPECT_NEAR(number(row, "upper"), 1.75, kTolerance) << how;
    EXPECT_NEAR(number(row, "t_minimum"), 1.0, 2e-3) << how;
    EXPECT_EQ(row.at("contact"), "true") << how;
    const double contact = 1.0 - std::sqrt(0.5);  // the slider is at -0.25
    EXPECT_LE(number(row, "t_free"), contact + 1e-12) << how;
    EXPECT_NEAR(number(row, "t_contact"), contact, 2e-6) << how;
  }
  const auto json = nlohmann::json::parse(
      run(swing(1.0), "--trajectory --interpolation cubic --contact-distance 2 --format json").output);
  EXPECT_NEAR(json.at(0).at("contact_state").at("slide").get<double>(), -0.25, 2e-6);
}

TEST_F(ClearanceTrajectory, TubesAreProvenToTheirBorder) {
  // The distance is 2.25 + slide, but sled and ball move by 1 and 2 for it, and each is bounded by itself.
  const Row row = segments("slide\n0\n0\n", "--tracking-error 0.1").at(0);
  EXPECT_LE(number(row, "lower"), 2.15);
  EXPECT_GE(number(row, "lower"), 2.25 - 0.3 - kTolerance);
  EXPECT_NEAR(number(row, "upper"), 2.15, kTolerance);
  EXPECT_EQ(run("slide\n0\n0\n", "--trajectory --tracking-error 0.1 --assert-above 1.9").exit_code, 0);
  EXPECT_EQ(run("slide\n0\n0\n", "--trajectory --tracking-error 0.1 --assert-above 2.2").exit_code, 2);
}

TEST_F(ClearanceTrajectory, TrackingErrorsAreThoseOfAFile) {
  const auto lower = [&](const std::string& error) {
    return number(segments("slide\n0\n0\n", "--tracking-error " + error).at(0), "lower");
  };
  const double of_slide = lower("0.1");
  EXPECT_LT(of_slide, 2.2);
  EXPECT_EQ(lower(files_.write("some.yaml", "slide: 0.1\n")), of_slide);
  EXPECT_EQ(lower(files_.write("all.yaml", "{'*': 0.1}\n")), of_slide);
  EXPECT_EQ(lower(files_.write("none.yaml", "{slide: 0, '*': 0.1}\n")), lower("0"));
  const std::string constraints =
      "constraints: {goal_time: 0.6, stopped_velocity_tolerance: 0.05, "
      "slide: {trajectory: 0.1, goal: 0.05}}";
  EXPECT_EQ(lower(files_.write("controller.yaml", "arm_controller: {" + constraints + "}\n")), of_slide);
  EXPECT_EQ(lower(files_.write("constraints.yaml", constraints + "\n")), of_slide);
}

TEST_F(ClearanceTrajectory, TrackingErrorsInDegreesAreThoseOfJointsThatTurn) {
  const CommandResult result = run("slide\n0\n0\n", "--trajectory --tracking-error 0.5deg");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(says(result.errors, "joint \"slide\" is prismatic and taken to be exact")) << result.errors;
  const std::string arguments = crossingSliders();
  const std::string rest = "time,spin,approach\n0,0,2\n1,0,2\n";
  const auto lower = [&](const std::string& error) {
    return number(segments(rest, arguments + " --tracking-error " + error).at(0), "lower");
  };
  EXPECT_EQ(lower("30deg"), lower(files_.write("spin.yaml", "spin: " + shortest(std::acos(-1.0) / 6.0) + "\n")));
  EXPECT_EQ(lower("30deg"), lower(files_.write("degrees.yaml", "spin: 30deg\n")));
  EXPECT_LT(lower("30deg"), lower("0"));
}

TEST_F(ClearanceTrajectory, BeginsInTheStateOfTheController) {
  const std::string states = "time,slide\n-1,5\n0,4\n2,0\n3,-0.5\n";
  const std::vector<Row> rows = segments(states, "--start slide=0.5");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("t_begin") + " " + rows[0].at("t_end") + " " + rows[1].at("t_end"), "0 2 3");
  EXPECT_NEAR(number(rows[0], "lower"), 2.25, kTolerance);
  EXPECT_NEAR(number(rows[1], "lower"), 1.75, kTolerance);
  EXPECT_EQ(segments(states, "--start " + files_.write("start.csv", "slide\n0.5\n")).at(0), rows[0]);
  EXPECT_EQ(segments("slide\n7\n0\n", "--start slide=0.5").size(), 1U) << "one way point suffices";
}

TEST_F(ClearanceTrajectory, BeginsWithTheVelocityOfTheStart) {
  const std::string states = "time,slide,slide.velocity\n2,0,1\n", cubic = "--interpolation cubic --start ";
  EXPECT_NEAR(
      number(segments(states, cubic + files_.write("moves.csv", "slide,slide.velocity\n0,-1\n")).at(0), "lower"), 1.75,
      kTolerance);
  // At rest: 2 (s^3 - s^2) with s = t / 2, lowest at s = 2 / 3.
  EXPECT_NEAR(number(segments(states, cubic + "slide=0").at(0), "lower"), 2.25 - 8.0 / 27.0, kTolerance);
}

TEST_F(ClearanceTrajectory, StartTakesTheShorterWayOfAContinuousJoint) {
  const std::string arguments = crossingSliders();
  const double corner = 1.0 - kCorner - 0.25;
  EXPECT_NEAR(number(segments("time,spin,approach\n0,6,2\n1,0.2,2\n2,6,2\n", arguments).at(0), "lower"), corner, 1e-5);
  const std::vector<Row> rows =
      segments("time,spin,approach\n1,0.2,2\n2,6,2\n3,6,2\n", arguments + " --start spin=6,approach=2");
  EXPECT_GT(number(rows.at(0), "lower"), corner + 0.005);
  EXPECT_NEAR(number(rows.at(1), "lower"), corner, 1e-5) << "between way points it goes as they say";
}

TEST_F(ClearanceTrajectory, SplinesBeyondALimitAreNamed) {
  const CommandResult beyond = run(swing(3.0), "--trajectory --interpolation cubic");
  EXPECT_EQ(beyond.exit_code, 0) << beyond.errors;
  EXPECT_TRUE(
      says(beyond.errors, "in 1 segment. That is segment 0, at 1 s: \"slide\" is at -1.5 m, its limit is -1 m."))
      << beyond.errors;
  EXPECT_FALSE(says(run(swing(1.0), "--trajectory --interpolation cubic").errors, "limit"));
}

}  // namespace proximity_server::tools::clearance_trajectory_test
