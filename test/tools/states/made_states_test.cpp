// Samples and grids.
#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "sanitized.h"
#include "scene/files.h"
#include "tools/states/arm.h"
#include "tools/states/grid_states.h"
#include "tools/states/sampled_states.h"

#include <Random123/philox.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace proximity_server::tools::made_states_test {

using namespace scene;

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kMany = std::numeric_limits<std::int64_t>::max();

using Words = std::array<std::uint32_t, 4>;

/// Philox4x32-10, written down from the paper (section 3.3).
Words philox(Words counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * counter[0], b = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

/// Asks the library itself, for the test of the known answers.
Words libraryPhilox(const Words& counter, const std::array<std::uint32_t, 2>& key) {
  const r123::Philox4x32::ctr_type in{{counter[0], counter[1], counter[2], counter[3]}};
  const r123::Philox4x32::ctr_type out = r123::Philox4x32()(in, {{key[0], key[1]}});
  return {out[0], out[1], out[2], out[3]};
}

// Source: the known answers that come with the paper (kat_vectors).
TEST(Philox, GivesTheKnownAnswers) {
  constexpr std::uint32_t kOnes = 0xFFFFFFFF;
  const struct {
    Words counter;
    std::array<std::uint32_t, 2> key;
    Words answer;
  } cases[] = {
      {{0, 0, 0, 0}, {0, 0}, {0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8}},
      {{kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}, {0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD}},
      {{0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344},
       {0xA4093822, 0x299F31D0},
       {0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1}},
  };
  for (const auto& one : cases) {
    EXPECT_EQ(philox(one.counter, one.key), one.answer);
    EXPECT_EQ(libraryPhilox(one.counter, one.key), one.answer);
  }
}

TEST(UniformNumbers, AreTheTopBitsOfTheWordsOfTheirCounter) {
  for (const std::uint64_t seed : {0UL, 7UL, 0x123456789ABCDEF0UL}) {
    for (const std::uint64_t state : {0UL, 1UL, 0xFFFFFFFFUL, 0x100000000UL, 0x7FFFFFFFFFFFFFFFUL}) {
      for (const std::uint32_t draw : {0U, 3U}) {
        const Words words =
            philox({static_cast<std::uint32_t>(state), static_cast<std::uint32_t>(state >> 32), draw, 0},
                   {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
        const std::array<double, 2> numbers = uniformNumbers(seed, state, draw);
        for (const int i : {0, 1}) {
          const std::uint64_t bits = std::uint64_t{words[2 * i + 1]} << 32 | words[2 * i];
          EXPECT_EQ(numbers[i], std::ldexp(static_cast<double>(bits >> 11), -53));
          EXPECT_GE(numbers[i], 0.0);
          EXPECT_LT(numbers[i], 1.0);
        }
      }
    }
  }
}

TEST(SampledStates, PlaceEveryJointInItsRangeByItsOwnNumber) {
  SampledStates states(10, 5, arm());
  const std::vector<Positions> all = restOf(states);
  ASSERT_EQ(all.size(), 10U);
  for (std::uint64_t i = 0; i < 10; ++i) {
    const auto [elbow, lift] = uniformNumbers(5, i, 0);
    const double wheel = uniformNumbers(5, i, 1)[0];
    EXPECT_EQ(all[i], at(-2.0 + elbow * 5.0, 0.5 * lift, -kPi + wheel * (2.0 * kPi)));
  }
}

TEST(SampledStates, AreTheSameFromAnyStateOnAndForAnyNumberOfThem) {
  const std::vector<Positions> all = restOf(SampledStates(100, 3, arm()));
  for (const std::uint64_t first : {0U, 1U, 57U, 99U, 100U, 1000U}) {
    SampledStates states(100, 3, arm());
    states.skipTo(first);
    const std::vector<Positions> rest = restOf(states);
    const auto skipped = static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(first, 100));
    EXPECT_EQ(rest, std::vector<Positions>(all.begin() + skipped, all.end()));
  }
  const std::vector<Positions> few = restOf(SampledStates(10, 3, arm()));
  EXPECT_EQ(few, std::vector<Positions>(all.begin(), all.begin() + 10));
  SampledStates many(kMany, 3, arm());
  EXPECT_EQ(many.count(), kMany);
  many.skipTo(kMany - 1);
  EXPECT_EQ(restOf(many).size(), 1U);
}

// With n numbers in k equal cells, the sum of (counted - n / k)^2 / (n / k) is chi-square with k - 1 degrees of
// freedom: it exceeds 63 + 5 sqrt(126) less than once in a million. The correlation of two joints is below 5 / sqrt(n)
// likewise.
TEST(SampledStates, FillTheirRangesUniformlyAndIndependently) {
  const int n = repeats(200000), cells = 64;
  SampledStates states(static_cast<std::uint64_t>(n), 1, arm());
  std::vector<int> counts(cells, 0);
  double product = 0.0;
  for (scene::TrajectoryPoint state; states.next(state);) {
    const double elbow = (state.positions[joint("elbow")] + 2.0) / 5.0, lift = 2.0 * state.positions[joint("lift")];
    ++counts.at(static_cast<std::size_t>(elbow * cells));
    product += (elbow - 0.5) * (lift - 0.5) * 12.0;
  }
  double chi_square = 0.0;
  for (const int count : counts) chi_square += std::pow(count - 1.0 * n / cells, 2.0) / (1.0 * n / cells);
  EXPECT_LT(chi_square, 63.0 + 5.0 * std::sqrt(126.0));
  EXPECT_GT(chi_square, 63.0 - 5.0 * std::sqrt(126.0)) << "too even to be random";
  EXPECT_LT(std::abs(product), 5.0 * std::sqrt(n));
}

RobotModel limitedArm(const std::string& inequalities) {
  RobotModel robot = arm();
  setJointInequalities(readYaml(inequalities, ""), "", robot);
  return robot;
}

TEST(SampledStates, ThatBreakAnInequalityAreDrawnAgainOfTheSameState) {
  const RobotModel robot = limitedArm("- elbow + 4*lift <= 0");
  const std::vector<Positions> all = restOf(SampledStates(1000, 3, robot)),
                               free = restOf(SampledStates(1000, 3, arm()));
  int kept = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    std::uint32_t attempt = 0;
    const auto drawn = [&] {
      const auto [elbow, lift] = uniformNumbers(3, i, 0, attempt);
      return at(-2.0 + elbow * 5.0, 0.5 * lift, -kPi + uniformNumbers(3, i, 1, attempt)[0] * (2.0 * kPi));
    };
    while (drawn()[joint("elbow")] + 4.0 * drawn()[joint("lift")] > 5e-6) ++attempt;
    EXPECT_EQ(all[i], drawn()) << i;
    kept += all[i] == free[i];
  }
  EXPECT_NEAR(kept, 200, 60) << "of the rectangle of 5 by 2, a triangle of 2 by 2";
  SampledStates later(1000, 3, robot);
  later.skipTo(990);
  EXPECT_EQ(restOf(later), std::vector<Positions>(all.begin() + 990, all.end()));
}

TEST(SampledStates, ThatNoDrawGivesAreAnErrorThatNamesTheInequality) {
  const RobotModel robot = limitedArm("- lift <= 0.4\n- elbow >= 3");
  SampledStates states(10, 3, robot);
  scene::TrajectoryPoint state;
  try {
    states.next(state);
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(error.what(), std::string("--sample 10 --seed 3: none of 1000000 random states obeys the joint "
                                        "inequalities; 'elbow >= 3' refuses most"));
  }
}

TEST(SampledStates, AreIdentifiedByNumberSeedAndRanges) {
  const std::string identity = SampledStates(10, 1, arm()).identity();
  EXPECT_EQ(SampledStates(10, 1, arm()).identity(), identity);
  EXPECT_NE(SampledStates(11, 1, arm()).identity(), identity);
  EXPECT_NE(SampledStates(10, 2, arm()).identity(), identity);
  RobotModel other = arm();
  other.joints[joint("lift")].upper = 0.6;
  EXPECT_NE(SampledStates(10, 1, other).identity(), identity);
  EXPECT_NE(SampledStates(10, 1, limitedArm("- lift <= 0.4")).identity(), identity);
}

TEST(SampledStates, SayWhereARangeIsAGuessAndRefuseOneWithoutWidth) {
  RobotModel robot = arm();
  EXPECT_TRUE(SampledStates(1, 0, robot).header().warnings.empty());
  Joint& lift = robot.joints[joint("lift")];
  lift.lower = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(SampledStates(1, 0, robot).header().warnings.at(0),
            "--sample 1 --seed 0: joint \"lift\" has no limits: from -1 m to 1 m is a guess.");
  lift.lower = -1e308;
  lift.upper = 1e308;
  EXPECT_EQ(errorOf([&] { SampledStates(1, 0, robot); }),
            "--sample 1 --seed 0: joint \"lift\": its limits are too wide");
}

GridStates gridOf(const std::vector<std::string>& texts) {
  std::vector<GridAxis> axes;
  for (const std::string& text : texts) axes.push_back(readGridAxis(text));
  return GridStates(axes, arm());
}

TEST(GridStates, RunThroughTheLastAxisFirst) {
  const std::vector<Positions> states = restOf(gridOf({"wheel=-1:1:3", "elbow=0:1:2", "lift=0.25"}));
  EXPECT_EQ(states, (std::vector<Positions>{at(0.0, 0.25, -1.0), at(1.0, 0.25, -1.0), at(0.0, 0.25, 0.0),
                                            at(1.0, 0.25, 0.0), at(0.0, 0.25, 1.0), at(1.0, 0.25, 1.0)}));
}

TEST(GridStates, AreInDegreesToo) {
  EXPECT_EQ(restOf(gridOf({"elbow=-90deg:1:2"})),
            (std::vector<Positions>{at(-kPi / 2.0, 0.0, 0.0), at(1.0, 0.0, 0.0)}));
  EXPECT_EQ(errorOf([] { gridOf({"lift=10deg"}); }),
            "--grid: joint \"lift\": it is prismatic: its positions are in metres");
  EXPECT_EQ(errorOf([] { gridOf({"elbow=1 rad"}); }),
            "'elbow=1 rad': \"1 rad\" is no finite number, nor an angle like 90deg");
}

// 0.7 is no multiple of a third of it in doubles.
TEST(GridStates, EndWhereTheAxisEnds) {
  const std::vector<Positions> states = restOf(gridOf({"elbow=0.1:0.7:8"}));
  ASSERT_EQ(states.size(), 8U);
  EXPECT_EQ(states.front(), at(0.1, 0.0, 0.0));
  EXPECT_EQ(states.back(), at(0.7, 0.0, 0.0));
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(states[i][joint("elbow")], 0.1 + 0.6 * i / 7.0, 1e-15);
}

TEST(GridStates, OfAllJointsFillTheirLimitsAndOneTurn) {
  const std::vector<Positions> states = restOf(gridOf({"4"}));
  ASSERT_EQ(states.size(), 64U);
  EXPECT_EQ(states[0], at(-2.0, 0.0, -kPi));
  EXPECT_EQ(states[1], at(-2.0, 0.0, -kPi / 2.0));
  EXPECT_EQ(states[3], at(-2.0, 0.0, kPi / 2.0)) << "the end of a turn is its begin";
  EXPECT_EQ(states[60], at(3.0, 0.5, -kPi));
  EXPECT_EQ(std::set<Positions>(states.begin(), states.end()).size(), 64U);
}

TEST(GridStates, OfAllJointsHaveOnePositionOfAJointThatCannotMove) {
  RobotModel robot = arm();
  robot.joints[joint("elbow")].lower = robot.joints[joint("elbow")].upper = 1.0;
  GridStates states({readGridAxis("3")}, robot);
  EXPECT_EQ(states.count(), 9U);
  EXPECT_EQ(restOf(states)[0], at(1.0, 0.0, -kPi));
}

TEST(GridStates, AreTheSameFromAnyStateOn) {
  const std::vector<Positions> all = restOf(gridOf({"wheel=-1:1:5", "elbow=0:1:3", "lift=0:0.5:4"}));
  ASSERT_EQ(all.size(), 60U);
  for (std::uint64_t first = 0; first <= 61; ++first) {
    GridStates states = gridOf({"wheel=-1:1:5", "elbow=0:1:3", "lift=0:0.5:4"});
    states.skipTo(first);
    const auto skipped = static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(first, 60));
    EXPECT_EQ(restOf(states), std::vector<Positions>(all.begin() + skipped, all.end())) << first;
  }
}

TEST(GridStates, CountUpToTheLargestNumberAndRefuseMore) {
  GridStates states = gridOf({"wheel=-1:1:2147483647", "elbow=0:1:4294967296"});
  EXPECT_EQ(states.count(), 2147483647UL * 4294967296UL);
  states.skipTo(*states.count() - 1);
  EXPECT_EQ(restOf(states), std::vector<Positions>{at(1.0, 0.0, 1.0)});
  EXPECT_EQ(errorOf([] {
              gridOf({"wheel=-1:1:2147483648", "elbow=0:1:4294967296"});
            }),
            "--grid: more states than a number of 64 bits can count")
      << "2^63";
  EXPECT_EQ(errorOf([] {
              gridOf({"wheel=-1:1:4294967296", "elbow=0:1:4294967296"});
            }),
            "--grid: more states than a number of 64 bits can count")
      << "2^64, which is 0 in 64 bits";
}

TEST(GridStates, RefuseAxesThatAreNone) {
  const auto errorFor = [](const std::vector<std::string>& texts) { return errorOf([&] { gridOf(texts); }); };
  EXPECT_EQ(errorFor({"elbw=0"}), "--grid: joint \"elbw\": no such joint (did you mean \"elbow\"?)");
  EXPECT_EQ(errorFor({"time=0"}), "--grid: joint \"time\": no such joint");
  EXPECT_EQ(errorFor({"weld=0"}), "--grid: joint \"weld\": a fixed joint has no position");
  EXPECT_EQ(errorFor({"base=0"}), "--grid: joint \"base\": a floating or planar joint has more than one position");
  EXPECT_EQ(errorFor({"finger=0"}), "--grid: joint \"finger\": the joint follows \"lift\"");
  EXPECT_EQ(errorFor({"elbow=0", "elbow=1"}), "--grid: joint \"elbow\": named twice");
  EXPECT_EQ(errorFor({"3", "elbow=1"}), "--grid: a number for all joints stands alone");
  EXPECT_EQ(errorFor({"1"}), "'1': a grid of all joints has at least 2 positions of each");
  EXPECT_EQ(errorFor({"=1"}), "'=1': there is no joint");
  EXPECT_EQ(errorFor({"elbow=1:0:3"}), "'elbow=1:0:3': the lower end is not below the upper one");
  EXPECT_EQ(errorFor({"elbow=0:1:1"}), "'elbow=0:1:1': from one end to the other are at least 2 positions");
  EXPECT_EQ(errorFor({"elbow=-1e308:1e308:2"}), "'elbow=-1e308:1e308:2': too wide");
  EXPECT_EQ(errorFor({"elbow=0:1"}), "'elbow=0:1': expected JOINT=LOWER:UPPER:COUNT, JOINT=POSITION or COUNT");
  for (const std::string number : {"", "nan", "inf", "x"})
    EXPECT_EQ(errorFor({"elbow=0:" + number + ":3"}),
              "'elbow=0:" + number + ":3': \"" + number + "\" is no finite number, nor an angle like 90deg");
  for (const std::string number : {"", "0", "-1", "1.5", "9007199254740993", "3:3", "99999999999999999999"})
    EXPECT_EQ(errorFor({"elbow=0:1:" + number}), "'elbow=0:1:" + number + "': \"" + number +
                                                     "\" is no whole number of positions from 1 to 9007199254740992");
}

TEST(GridStates, SayWhichAreBeyondALimitAndWhatTheyAre) {
  GridStates states = gridOf({"elbow=0:4:5"});
  restOf(states);
  EXPECT_EQ(
      states.limitWarning(),
      "--grid: 1 of 5 states are beyond the limits of a joint. The first is state 4: \"elbow\" is at 4 rad, its limits "
      "are -2 and 3 rad.");
  EXPECT_EQ(states.identity(), gridOf({"elbow=0:4:5"}).identity());
  for (const std::string other : {"elbow=0:4:6", "elbow=0:5:5", "elbow=1:4:5", "wheel=0:4:5"})
    EXPECT_NE(gridOf({other}).identity(), states.identity()) << other;
}

}  // namespace proximity_server::tools::made_states_test
