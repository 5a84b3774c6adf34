// The text of a row, for any numbers and names: JSON as its library writes it, and the same values in CSV.
#include "tools/clearance/clearance_rows.h"

#include "scene/small_robots.h"
#include "tools/robot/two_sliders.h"
#include "tools/text/csv.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <random>

namespace proximity_server::tools::clearance_rows_test {

using Json = nlohmann::ordered_json;

/// A robot whose links have names that neither CSV nor JSON has as they are.
std::shared_ptr<const scene::SceneModel> oddlyNamed() {
  scene::RobotModel robot = scene::robotOf(kTwoSliders);
  robot.links[0].name = " say \"no\"\\\t";
  robot.links[1].name = "\xc3\xa4, \xff";
  return scene::modelOf(robot);
}

/// Every double is as likely as any other one, also those that are not finite.
double anyNumber(std::mt19937_64& random) {
  const std::uint64_t bits = random() % 20 == 0 ? 0x7ff0000000000000U : random();
  double number = 0.0;
  std::memcpy(&number, &bits, sizeof number);
  return number;
}

scene::PairProximity anyProximity(std::mt19937_64& random) {
  scene::PairProximity pair;
  pair.asked = {{0}, {1}};
  narrowphase::SignedDistance& result = pair.result;
  for (double* const number : {&result.distance, &result.lower_bound, &result.upper_bound}) *number = anyNumber(random);
  for (Eigen::Vector3d* const vector : {&result.point_a, &result.point_b, &result.normal})
    for (int i = 0; i < 3; ++i) (*vector)[i] = anyNumber(random);
  return pair;
}

TEST(StateRows, SayTheSameInCsvAndAsJsonWritesIt) {
  ClearanceQuestion question;
  question.model = oddlyNamed();
  question.uncertainty.emplace();
  const StateRows csv_rows(question, RowFormat::Csv), json_rows(question, RowFormat::Json);
  const std::vector<std::string> columns = csvFields(csv_rows.format().begin);
  std::mt19937_64 random(3);
  int numbers = 0, not_finite = 0;
  for (std::uint64_t state = 0; state < 2000; ++state) {
    const scene::PairProximity pair = anyProximity(random);
    WrittenRows csv, json;
    const double guaranteed = anyNumber(random);
    csv_rows.addPair(state, pair, guaranteed, nullptr, csv);
    json_rows.addPair(state, pair, guaranteed, nullptr, json);
    const Json parsed = Json::parse(json.bytes);
    ASSERT_EQ(parsed.dump(), json.bytes);
    const std::vector<std::string> fields = csvFields(csv.bytes);
    ASSERT_EQ(fields.size(), columns.size());
    ASSERT_EQ(parsed.size(), columns.size());
    EXPECT_EQ(fields[1], " say \"no\"\\\t");
    EXPECT_EQ(fields[2], "\xc3\xa4, \xff");
    EXPECT_EQ(parsed["link_a"], fields[1]);
    EXPECT_EQ(parsed["link_b"], "\xc3\xa4, \xef\xbf\xbd") << "U+FFFD stands for what is not UTF-8";
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Json& value = parsed[columns[i]];
      if (value.is_number_float()) {
        EXPECT_EQ(numberIn<double>(fields[i]), value.get<double>()) << columns[i];
        ++numbers;
      } else if (value.is_null()) {
        EXPECT_FALSE(finiteNumber(fields[i])) << columns[i];
        ++not_finite;
      }
    }
    EXPECT_EQ(parsed["distance"].is_null(), !std::isfinite(pair.result.distance));
  }
  EXPECT_GT(numbers, 20000);
  EXPECT_GT(not_finite, 1000);
}

}  // namespace proximity_server::tools::clearance_rows_test
