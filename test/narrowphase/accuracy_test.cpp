// The accuracy table of README.md, measured. It fails when a pair gets worse, and when it gets much better than stated.
#include <gtest/gtest.h>

#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <sstream>

#include "narrowphase/certificate.h"
#include "narrowphase/shape_pairs.h"

namespace proximity_server {
namespace {

/// Worst errors [m] over random poses of shapes of size about 1, at the default tolerance of 1e-9 m.
struct Accuracy {
  double apart = 0.0;
  double depth = 0.0;
};

constexpr int kPoses = 200;

Accuracy measured(const Shape& a, const Shape& b, const std::string& name) {
  std::mt19937 random(61);
  Accuracy worst;
  int overlaps = 0;
  for (int i = 0; i < kPoses; ++i) {
    const double reach = 1.5 * (a.coreRadius() + a.margin() + b.coreRadius() + b.margin());
    const PairCase c{name, a, b, randomPose(random, reach)};
    const Truth truth = signedDistanceOracle(c.pair());
    const double error = std::abs(static_cast<double>(signedDistance(a, b, c.a_T_b).distance - truth.distance));
    double& column = truth.distance < 0 ? worst.depth : worst.apart;
    column = std::max(column, error);
    overlaps += truth.distance < 0 ? 1 : 0;
  }
  EXPECT_GT(overlaps, 3 * kPoses / 10) << name;
  EXPECT_LT(overlaps, 7 * kPoses / 10) << name;
  return worst;
}

/// Rows "| sphere-box | 2e-16 | 3e-16 |" between the markers of README.md: pair, apart, overlapping.
std::map<std::string, Accuracy> stated() {
  std::ifstream file(std::string(PROXIMITY_SOURCE_DIR) + "/README.md");
  std::stringstream text;
  text << file.rdbuf();
  const std::string readme = text.str();
  const std::size_t from = readme.find("<!-- accuracy -->"), to = readme.find("<!-- /accuracy -->");
  std::map<std::string, Accuracy> rows;
  if (from == std::string::npos || to == std::string::npos) return rows;
  const std::string block = readme.substr(from, to - from);
  const std::regex row(R"(\| ([a-z]+-[a-z]+) \| (\S+) \| (\S+) \|)");
  for (std::sregex_iterator it(block.begin(), block.end(), row), end; it != end; ++it)
    rows[(*it)[1]] = {std::stod((*it)[2]), std::stod((*it)[3])};
  return rows;
}

std::map<std::string, Accuracy> allMeasured() {
  std::map<std::string, Accuracy> rows;
  const std::vector<NamedShape> shapes = solidShapes();
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = i; j < shapes.size(); ++j) {
      const std::string name = shapes[i].name + "-" + shapes[j].name;
      rows[name] = measured(shapes[i].shape, shapes[j].shape, name);
    }
  return rows;
}

void expectAsStated(const std::string& what, double error, double limit) {
  EXPECT_LE(error, limit) << what << " is worse than README.md states";
  EXPECT_GE(error, limit / 10.0) << what << " is much better than README.md states: tell the users";
}

TEST(Accuracy, IsAsStatedInTheReadme) {
  const std::map<std::string, Accuracy> table = stated(), rows = allMeasured();
  for (const auto& [pair, worst] : rows)
    std::cout << "| " << pair << " | " << worst.apart << " | " << worst.depth << " |\n";
  for (const auto& [pair, worst] : rows) {
    ASSERT_TRUE(table.count(pair)) << "README.md has no row for " << pair;
    expectAsStated(pair + " apart", worst.apart, table.at(pair).apart);
    expectAsStated(pair + " overlapping", worst.depth, table.at(pair).depth);
  }
}

}  // namespace
}  // namespace proximity_server
