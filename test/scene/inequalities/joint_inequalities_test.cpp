#include "proximity_server/scene/inequalities/joint_inequalities.h"

#include "chance.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/model/posed_position.h"
#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace proximity_server::scene::joint_inequalities_test {

constexpr double kPi = 3.14159265358979323846;

std::string turning(const std::string& name, const std::string& child, const std::string& limit,
                    const std::string& more = "") {
  return joint(name, "revolute", "base", child, axis("0 0 1") + limit + more);
}

/// The joints j1, j2 and j1-j2 from -2 to 2 rad, "lift" from 0 to 1 m, the continuous joint "spin"; "twin" is at 0.5 +
/// 3 j1.
RobotModel robotOfJoints() {
  const std::string two = limits("-2", "2");
  return robotOf(urdfOf(
      link("base") + link("a") + link("b") + link("c") + link("d") + link("e") + link("f") + link("g") + link("h") +
      turning("j1", "a", two) + turning("j2", "b", two) + turning("j1-j2", "c", two) +
      turning("twin", "d", limits("-99", "99"), "<mimic joint='j1' multiplier='3' offset='0.5'/>") +
      joint("lift", "prismatic", "base", "e", axis("0 0 1") + limits("0", "1")) + hinge("spin", "base", "f", "0 0 1") +
      weld("welded", "base", "g") + joint("cart", "floating", "base", "h")));
}

std::vector<JointInequality> read(const std::string& yaml) {
  RobotModel robot = robotOfJoints();
  setJointInequalities(readYaml(yaml, "limits.yaml"), "limits.yaml", robot);
  return robot.inequalities;
}

std::map<std::string, double> termsOf(const JointInequality& inequality) {
  const RobotModel robot = robotOfJoints();
  std::map<std::string, double> terms;
  for (const JointInequality::Term& term : inequality.terms) terms[robot.joints[term.joint].name] = term.coefficient;
  return terms;
}

using Terms = std::map<std::string, double>;

/// Expects that a refusal has these parts.
void expectIn(const std::string& refusal, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_NE(refusal.find(part), std::string::npos) << part << " in " << refusal;
}

TEST(JointInequalities, AreReadAsTheyAreWritten) {
  const auto inequalities = read("- 2*j1 - j2 <= 1.7");
  ASSERT_EQ(inequalities.size(), 1u);
  EXPECT_EQ(inequalities[0].text, "2*j1 - j2 <= 1.7");
  EXPECT_EQ(termsOf(inequalities[0]), (Terms{{"j1", 2.0}, {"j2", -1.0}}));
  EXPECT_EQ(inequalities[0].bound, 1.7);
}

TEST(JointInequalities, HaveSigns) {
  const auto inequalities = read("- -j1 + -2*(j2 - -1) <= 3e0*-lift+1e-0-1");
  ASSERT_EQ(inequalities.size(), 1u);
  EXPECT_EQ(termsOf(inequalities[0]), (Terms{{"j1", -1.0}, {"j2", -2.0}, {"lift", 3.0}}));
  EXPECT_EQ(inequalities[0].bound, 2.0);
}

TEST(JointInequalities, MoveAllJointsToOneSide) {
  const auto inequalities = read("[\"j1 + 0.5 >= 1e-1*lift*2 - (j2 - .25)\"]");
  ASSERT_EQ(inequalities.size(), 1u);  // 0.2 lift - j2 + 0.25 - j1 - 0.5 <= 0
  EXPECT_EQ(termsOf(inequalities[0]), (Terms{{"lift", 0.2}, {"j2", -1.0}, {"j1", -1.0}}));
  EXPECT_EQ(inequalities[0].bound, 0.25);
}

TEST(JointInequalities, OfTwoComparisonsAreTwo) {
  const auto inequalities = read("joint_inequalities:\n- -90 deg <= 1.5*(j1 - j2) <= 45deg\n");
  ASSERT_EQ(inequalities.size(), 2u);
  EXPECT_EQ(termsOf(inequalities[0]), (Terms{{"j1", -1.5}, {"j2", 1.5}}));
  EXPECT_DOUBLE_EQ(inequalities[0].bound, kPi / 2.0);
  EXPECT_EQ(termsOf(inequalities[1]), (Terms{{"j1", 1.5}, {"j2", -1.5}}));
  EXPECT_DOUBLE_EQ(inequalities[1].bound, kPi / 4.0);
}

TEST(JointInequalities, OfAFollowerAreOfItsLeader) {
  const auto inequalities = read("- twin + j1 <= 2");  // 3 j1 + 0.5 + j1
  ASSERT_EQ(inequalities.size(), 1u);
  EXPECT_EQ(termsOf(inequalities[0]), (Terms{{"j1", 4.0}}));
  EXPECT_EQ(inequalities[0].bound, 1.5);
}

TEST(JointInequalities, TakeTheLongestNameOfAJoint) {
  EXPECT_EQ(termsOf(read("- j1-j2 <= 1").front()), (Terms{{"j1-j2", 1.0}}));
  EXPECT_EQ(termsOf(read("- j1 -j2 <= 1").front()), (Terms{{"j1", 1.0}, {"j2", -1.0}}));
}

TEST(JointInequalities, ThatCannotBeUsedAreRefusedWithTheirPlace) {
  const std::pair<const char*, const char*> refusals[] = {
      {"- j1 <= 1\n- j3 <= 1", "limits.yaml, line 2: [1]: 'j3 <= 1': there is no joint \"j3\" (did you mean \"j1\"?)"},
      {"- welded <= 1", "joint \"welded\" is fixed"},
      {"- cart <= 1", "joint \"cart\" is floating or planar"},
      {"- j1*j2 <= 1", "a product of joints is not linear"},
      {"- j1 < 1", "expected +, -, *, <= or >= before '< 1'"},
      {"- j1 == 1", "expected +, -, *, <= or >= before '== 1'"},
      {"- j1 + 1", "it has no <= or >="},
      {"- j1 <=", "expected a number or a joint at the end"},
      {"- (j1 <= 1", "a bracket is not closed"},
      {"- 2 j1 <= 1", "before 'j1 <= 1'"},
      {"- j1 + + j2 <= 1", "expected a number or a joint before '+ j2 <= 1'"},
      {"- 1 <= ---------------------j1", "nested more than 20 deep"},
      {"- 1 <= j1 >= 0", "not in the same direction"},
      {"- 0 <= j1 <= j2 <= 1", "more than two comparisons"},
      {"- j1 - j1 <= 1", "no joint is left in it"},
      {"- 1e400*j1 <= 1", "expected +, -, *, <= or >= before '0*j1 <= 1'"},
      {"- 1e300*1e300*j1 <= 1", "its numbers are too large"},
      {"- . <= j1", "'. <= j1' begins with no finite number"},
      {"- 1.2.3*j1 <= 1", "expected +, -, *, <= or >= before '.3*j1 <= 1'"},
      {"- 3", "must be a text"},
      {"limits: []", "limits"},
      {"j1 <= 1", "must be a list"}};
  for (const auto& [yaml, reason] : refusals) expectIn(errorOf([text = yaml] { read(text); }), {"limits.yaml", reason});
}

TEST(JointInequalities, ThatContradictEachOtherAreNamed) {
  expectIn(errorOf([] { read("- j1 + j2 >= 4.1"); }),
           {"no positions of the joints within their limits obey 'j1 + j2 >= 4.1'"});
  expectIn(errorOf([] { read("- lift <= 0.5\n- j1 - j2 <= -1\n- j1 >= j2\n- j2 <= 1"); }),
           {"obey 'j1 - j2 <= -1', 'j1 >= j2' together"});
  EXPECT_EQ(read("- j1 + j2 >= 4").size(), 1u) << "the upper limits of both obey it";
  EXPECT_EQ(read("- spin >= 100").size(), 1u);
  EXPECT_EQ(read("- j1 - j2 <= 0\n- j1 - j2 >= 0").size(), 2u);
}

TEST(JointInequalities, ThatAreNeverBrokenAreWarnings) {
  RobotModel robot = robotOfJoints();
  const std::size_t before = robot.warnings.size();
  setJointInequalities(readYaml("- -90 <= j1 <= 90\n- j1 + j2 >= -90\n- 0 <= j1 <= 90\n- spin <= 90", ""), "", robot);
  ASSERT_EQ(robot.warnings.size(), before + 2);
  EXPECT_EQ(robot.warnings[before],
            "joint_inequalities: '-90 <= j1 <= 90' is never broken: within the limits of its joints 88 are left at "
            "least. Degrees are written like 90deg.");
  EXPECT_NE(robot.warnings[before + 1].find("'j1 + j2 >= -90'"), std::string::npos);
}

TEST(JointInequalities, ARefusalKeepsThoseBefore) {
  RobotModel robot = robotOfJoints();
  setJointInequalities(readYaml("- j1 <= 1", ""), "", robot);
  EXPECT_NE(errorOf([&] { setJointInequalities(readYaml("- j1 <= -3", ""), "", robot); }), "");
  ASSERT_EQ(robot.inequalities.size(), 1u);
  EXPECT_EQ(robot.inequalities[0].text, "j1 <= 1");
}

/// The corners of the part of a polygon where x . normal <= bound.
using Polygon = std::vector<Eigen::Vector2d>;
Polygon clipped(const Polygon& polygon, const Eigen::Vector2d& normal, double bound) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double beyond_p = normal.dot(p) - bound, beyond_q = normal.dot(q) - bound;
    if (beyond_p <= 0.0) result.push_back(p);
    if ((beyond_p <= 0.0) != (beyond_q <= 0.0)) result.push_back(p + beyond_p / (beyond_p - beyond_q) * (q - p));
  }
  return result;
}

TEST(JointInequalities, OfTwoJointsAreRefusedIfAndOnlyIfTheirPolygonIsEmpty) {
  const RobotModel robot = robotOfJoints();
  const int j1 = findNamed(robot.joints, "j1"), j2 = findNamed(robot.joints, "j2");
  Chance chance(1);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    RobotModel limited = robot;
    Polygon inner{{-2, -2}, {2, -2}, {2, 2}, {-2, 2}}, outer = inner;
    FileValue::List texts;
    for (int n = 2 + chance.below(6); n > 0; --n) {
      const Eigen::Vector2d normal(chance.between(-2, 2), chance.between(-2, 2));
      const double bound = chance.between(-3, 2);
      constexpr double kMargin = 1e-4;
      inner = clipped(inner, normal, bound - kMargin);
      outer = clipped(outer, normal, bound + kMargin);
      texts.push_back({shortest(normal.x()) + "*j1 + " + shortest(normal.y()) + "*j2 <= " + shortest(bound), 0});
    }
    if (inner.empty() && !outer.empty()) continue;
    bool is_refused = false;
    try {
      setJointInequalities({texts, 0}, "", limited);
      ASSERT_EQ(limited.inequalities.front().terms.front().joint, std::min(j1, j2));
    } catch (const std::invalid_argument&) {
      is_refused = true;
    }
    EXPECT_EQ(is_refused, outer.empty()) << i;
    ++(is_refused ? refused : accepted);
  }
  EXPECT_GT(refused, 300);
  EXPECT_GT(accepted, 300);
}

/// A robot of so many joints, from -1 to 1.
RobotModel sliders(int count) {
  std::string parts = link("base");
  for (int i = 0; i < count; ++i) {
    const std::string name = std::to_string(i);
    parts += link("l" + name) + joint("q" + name, "prismatic", "base", "l" + name, axis("1 0 0") + limits("-1", "1"));
  }
  return robotOf(urdfOf(parts));
}

TEST(JointInequalities, OfManyJointsAreRefusedOnlyTogetherWithTheOneThatContradicts) {
  constexpr int kJoints = 12, kRows = 20;
  Chance chance(2);
  for (int i = 0; i < 100; ++i) {
    RobotModel robot = sliders(kJoints);
    const auto sum = [&](const Eigen::VectorXd& row) {
      std::string text = "0";
      for (int j = 0; j < kJoints; ++j) text += " + " + shortest(row[j]) + "*q" + std::to_string(j);
      return text;
    };
    Eigen::VectorXd point(kJoints);
    for (int j = 0; j < kJoints; ++j) point[j] = chance.between(-1, 1);
    FileValue::List texts;
    Eigen::VectorXd combined = Eigen::VectorXd::Zero(kJoints);
    double bound_of_combined = 0.0;
    for (int n = 0; n < kRows; ++n) {
      Eigen::VectorXd row(kJoints);
      for (int j = 0; j < kJoints; ++j) row[j] = chance.between(-1, 1);
      const double bound = row.dot(point) + (chance.happens(0.5) ? 0.0 : chance.between(0, 1));
      texts.push_back({sum(row) + " <= " + shortest(bound), 0});
      const double multiplier = chance.between(0, 1);
      combined += multiplier * row;
      bound_of_combined += multiplier * bound;
    }
    setJointInequalities({texts, 0}, "", robot);  // `point` obeys all
    std::map<std::string, double> at_point;
    for (int j = 0; j < kJoints; ++j) at_point["q" + std::to_string(j)] = point[j];
    EXPECT_EQ(mostBroken(robot.inequalities, byJoint(robot, at_point)), nullptr);
    texts.insert(texts.begin(), {sum(combined) + " >= " + shortest(bound_of_combined + 1e-3), 0});
    expectIn(errorOf([&] { setJointInequalities({texts, 0}, "", robot); }), {">="});
  }
}

TEST(JointInequalities, AreBrokenByMoreThanTheRoundingOfPositions) {
  const std::vector<JointInequality> inequalities = read("- 2*j1 - j2 <= 1.7\n- lift + j1 <= 1.5");
  const RobotModel robot = robotOfJoints();
  const auto broken = [&](double j1, double j2, double lift) -> std::string {
    const auto positions = byJoint(robot, {{"j1", j1}, {"j2", j2}, {"lift", lift}});
    const JointInequality* const most = mostBroken(inequalities, positions);
    return most ? most->brokenText(most->excess(positions)) : "";
  };
  EXPECT_EQ(broken(0.85, 0.0, 0.0), "");
  EXPECT_EQ(broken(0.85 + 0.99e-6, -0.99e-6, 0.0), "");  // each is rounded to six decimals at most
  EXPECT_EQ(broken(0.85 + 3e-6, 0.0, 0.0), "'2*j1 - j2 <= 1.7' is broken by 6e-06");
  EXPECT_EQ(broken(1.0, 0.1, 0.0), "'2*j1 - j2 <= 1.7' is broken by 0.2");
  EXPECT_EQ(broken(1.0, 0.1, 0.9), "'lift + j1 <= 1.5' is broken by 0.4");
}

TEST(JointInequalities, HoldInAllRandomPositions) {
  RobotModel robot = robotOfJoints();
  setJointInequalities(readYaml("- j1 >= 2*j2 + 1\n- lift <= 0.1", ""), "", robot);
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const Positions positions = randomPositions(robot, jointRanges(robot), random);
    EXPECT_LE(2.0 * positions[findNamed(robot.joints, "j2")] + 1.0, positions[findNamed(robot.joints, "j1")] + 3e-6);
    EXPECT_LE(positions[findNamed(robot.joints, "lift")], 0.1 + 1e-6);
  }
}

TEST(JointInequalities, ThatRandomPositionsCannotObeyAreNamed) {
  RobotModel robot = robotOfJoints();
  setJointInequalities(readYaml("- j1 >= -1.9\n- j1 + j2 + lift >= 4.99999", ""), "", robot);  // 5 is possible
  std::mt19937_64 random(1);
  expectIn(errorOf([&] { randomPositions(robot, jointRanges(robot), random); }),
           {"'j1 + j2 + lift >= 4.99999' refuses most"});
}

TEST(JointInequalities, OfJointsThatAreNotDrawnDoNotCount) {
  RobotModel robot = robotOfJoints();
  setJointInequalities(readYaml("- j1 >= j2 + 1", ""), "", robot);
  std::vector<JointRange> ranges;
  for (const JointRange& range : jointRanges(robot))
    if (range.joint == findNamed(robot.joints, "j1")) ranges.push_back(range);
  std::mt19937_64 random(1);
  int below = 0;
  for (int i = 0; i < 100; ++i)
    below += randomPositions(robot, ranges, random)[ranges.front().joint] < 0.0;  // j2 may be at -2
  EXPECT_GT(below, 30);
}

TEST(ExcessAt, IsThatOfThePositions) {
  RobotModel robot = robotOfJoints();
  setJointInequalities(readYaml("- 2*j1 - j2 + spin <= 1.7", ""), "", robot);
  const auto excess =
      excessAt(robot, robot.inequalities[0], forwardKinematics(robot, {{"j1", 1.0}, {"j2", -1.5}, {"spin", -1.0}}));
  ASSERT_TRUE(excess.has_value());
  EXPECT_NEAR(*excess, 2.0 + 1.5 - 1.0 - 1.7, 1e-12);
}

TEST(ExcessAt, TakesTheTurnThatIsStated) {
  RobotModel robot = robotOfJoints();
  setJointInequalities(readYaml("- -1*spin <= 0", ""), "", robot);
  const BodyPoses poses = forwardKinematics(robot, {{"spin", -1.0}});
  std::vector<std::optional<double>> stated(robot.joints.size());
  EXPECT_NEAR(excessAt(robot, robot.inequalities[0], poses).value(), 1.0, 1e-12);
  stated[findNamed(robot.joints, "spin")] = 5.5;
  EXPECT_NEAR(excessAt(robot, robot.inequalities[0], poses, stated).value(), 1.0 - 2.0 * kPi, 1e-12);
}

TEST(ExcessAt, OfTurnsThatLimitsAllowIsTheSmallest) {
  RobotModel robot = robotOf(urdfOf(link("base") + link("a") + turning("wide", "a", limits("-4", "4"))));
  const auto smallest = [&](const char* text, double position) {
    setJointInequalities(readYaml(std::string("- ") + text, ""), "", robot);
    return excessAt(robot, robot.inequalities[0], forwardKinematics(robot, {{"wide", position}})).value();
  };
  EXPECT_NEAR(smallest("wide <= 0", 3.0), 3.0 - 2.0 * kPi, 1e-12);  // it may be at -3.28
  EXPECT_NEAR(smallest("wide >= 0", 3.0), -3.0, 1e-12);
  EXPECT_NEAR(smallest("wide <= 0", 1.0), 1.0, 1e-12);  // -5.28 is beyond the limit
}

TEST(ExcessAt, IsUnknownWithoutAPose) {
  RobotModel robot = robotOfJoints();
  setJointInequalities(readYaml("- j1 + j2 <= 0", ""), "", robot);
  BodyPoses poses = forwardKinematics(robot, {{"j1", 0.25}});
  poses[bodyOf(robot, "a")].reset();
  std::vector<std::optional<double>> stated(robot.joints.size());
  stated[findNamed(robot.joints, "j1")] = 0.2;
  EXPECT_NEAR(excessAt(robot, robot.inequalities[0], poses, stated).value(), 0.25, 1e-12) << "twin tells it";
  poses[bodyOf(robot, "d")].reset();
  EXPECT_EQ(excessAt(robot, robot.inequalities[0], poses, stated), std::nullopt);
}

}  // namespace proximity_server::scene::joint_inequalities_test
