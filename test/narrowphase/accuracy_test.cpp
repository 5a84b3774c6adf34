// The accuracy table of the README.md beside this file, measured. It fails when a pair gets worse, and when it gets
// much better than stated.
#include "from_environment.h"
#include "narrowphase/certificate.h"
#include "oracle/refined_truth.h"
#include "oracle/shape_pairs.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <limits>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <utility>

namespace proximity_server::narrowphase::accuracy_test {

/// Worst errors [m] over random poses of shapes of size about 1, at the default tolerance of 1e-9 m.
///
/// Each pose has its proof:
/// * Cores apart (all poses): the error is against an enclosure of the truth that is proven in long double, by GJK or
///   by branch and bound, and counts the width of the enclosure too.
/// * Cores overlapping (all poses): the error is against the best direction near the answer's normal. A depth that
///   no neighbouring direction beats may still not be the smallest of all directions.
/// * Cores overlapping (the first kProvenPoses of each pair): also against the branch and bound over all directions.
struct Accuracy {
  double apart = 0.0;
  double depth = 0.0;
};

constexpr int kFullPoses = 100000;
constexpr int kProvenPoses = 100;

/// `./dev accuracy` asks for kFullPoses, which the table states; other runs take the first few of them.
int poses() { return static_cast<int>(fromEnvironment("PROXIMITY_ACCURACY_POSES", repeats(8000))); }

long double errorByBranchAndBound(const PairCase& c, const SignedDistance& result) {
  const Truth truth = signedDistanceOracle(c.pair());
  return std::abs(result.distance - truth.distance) + truth.error_bound;
}

/// The branch and bound decides if GJK in long double stalls before its enclosure is as narrow.
constexpr long double kNarrow = 1e-17L;

long double errorOf(const PairCase& c, const SignedDistance& result) {
  const RefinedTruth truth = refinedTruth(c.pair(), result.normal, result.distance);
  const long double off = std::abs(result.distance - truth.distance);
  if (!std::isfinite(truth.error_bound)) return off;
  return truth.error_bound <= kNarrow ? off + truth.error_bound : errorByBranchAndBound(c, result);
}

bool coresOverlap(const PairCase& c, const SignedDistance& result) {
  return result.distance + c.a.margin() + c.b.margin() <= 0.0;
}

Accuracy measured(const Shape& a, const Shape& b, const std::string& name) {
  std::mt19937 random(61);
  Accuracy worst;
  int overlaps = 0, proven = 0;
  for (int i = 0; i < poses(); ++i) {
    const double reach = 1.5 * (a.coreRadius() + a.margin() + b.coreRadius() + b.margin());
    const PairCase c{name, a, b, randomPose(random, reach)};
    const SignedDistance result = signedDistance(a, b, c.a_T_b);
    long double error = errorOf(c, result);
    if (coresOverlap(c, result) && proven++ < kProvenPoses) error = std::max(error, errorByBranchAndBound(c, result));
    double& column = result.distance < 0 ? worst.depth : worst.apart;
    column = std::max(column, static_cast<double>(error));
    overlaps += result.distance < 0 ? 1 : 0;
  }
  EXPECT_GT(overlaps, 3 * poses() / 10) << name;
  EXPECT_LT(overlaps, 7 * poses() / 10) << name;
  return worst;
}

/// The rows "| sphere-box | 2e-16 | 3e-16 |" between the markers of a README.md: pair, apart, overlapping.
std::map<std::string, Accuracy> statedIn(const std::string& path) {
  std::ifstream file(PROXIMITY_SOURCE_DIR "/" + path);
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

std::map<std::string, Accuracy> statedForAllPairs() { return statedIn("test/narrowphase/README.md"); }

/// The smallest and the largest error of a column of a table.
std::pair<double, double> range(const std::map<std::string, Accuracy>& table, double Accuracy::*column) {
  std::pair<double, double> ends(std::numeric_limits<double>::infinity(), 0.0);
  for (const auto& [pair, stated] : table) {
    ends.first = std::min(ends.first, stated.*column);
    ends.second = std::max(ends.second, stated.*column);
  }
  return ends;
}

struct Row {
  std::string pair;
  Accuracy worst;
};

std::vector<Row> allMeasured() {
  std::vector<Row> rows;
  const std::vector<NamedShape> shapes = solidShapes();
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = i; j < shapes.size(); ++j) {
      const std::string name = shapes[i].name + "-" + shapes[j].name;
      rows.push_back({name, measured(shapes[i].shape, shapes[j].shape, name)});
    }
  return rows;
}

/// One digit, never below the error: as the table states it.
std::string roundedUp(double error) {
  const double unit = std::pow(10.0, std::floor(std::log10(error)));
  std::ostringstream out;
  out << std::setprecision(1) << std::ceil(error / unit) * unit;
  return out.str();
}

void expectAsStated(const std::string& what, double error, double limit) {
  EXPECT_LE(error, limit) << what << " is worse than the table states";
  // A share of the poses may miss the worst one.
  if (poses() < kFullPoses) return;
  EXPECT_GE(error, limit / 10.0) << what << " is much better than the table states: tell the users";
}

TEST(Accuracy, IsAsStatedInTheTable) {
  const std::map<std::string, Accuracy> table = statedForAllPairs();
  const std::vector<Row> rows = allMeasured();
  for (const auto& [pair, worst] : rows)
    std::cout << "| " << pair << " | " << roundedUp(worst.apart) << " | " << roundedUp(worst.depth) << " |\n";
  for (const auto& [pair, worst] : rows) {
    ASSERT_TRUE(table.count(pair)) << "the table has no row for " << pair;
    expectAsStated(pair + " apart", worst.apart, table.at(pair).apart);
    expectAsStated(pair + " overlapping", worst.depth, table.at(pair).depth);
  }
}

TEST(Accuracy, TopReadmeHasTheBestAndTheWorstRows) {
  const std::map<std::string, Accuracy> all = statedForAllPairs(), shown = statedIn("README.md");
  for (const auto& [pair, stated] : shown) {
    ASSERT_TRUE(all.count(pair)) << pair;
    EXPECT_EQ(stated.apart, all.at(pair).apart) << pair;
    EXPECT_EQ(stated.depth, all.at(pair).depth) << pair;
  }
  for (double Accuracy::*column : {&Accuracy::apart, &Accuracy::depth})
    EXPECT_EQ(range(shown, column), range(all, column));
}

}  // namespace proximity_server::narrowphase::accuracy_test
