// The points of tracked sources: clouds of several layouts, and messages that state wrong sizes.
#include "node/sources/tracked_points.h"

#include "scene/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace proximity_server::node::tracked_points_test {

using Eigen::Vector3d;
using scene::errorOf;
using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;
using Points = std::vector<Vector3d>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// How a cloud stores its points.
struct Layout {
  std::uint8_t datatype = PointField::FLOAT32;
  std::uint32_t before = 0, after = 0;  ///< [bytes] of other fields before x and behind z
  std::uint32_t height = 1;
  std::uint32_t after_row = 0;  ///< [bytes]
  bool is_bigendian = false;
};

template <class Number>
void write(double value, bool is_bigendian, std::uint8_t* place) {
  const auto number = static_cast<Number>(value);
  std::memcpy(place, &number, sizeof number);
  if (is_bigendian != (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)) std::reverse(place, place + sizeof number);
}

PointCloud2 cloudOf(const Points& points, const Layout& layout = {}) {
  const bool is_float = layout.datatype == PointField::FLOAT32;
  const std::uint32_t size = is_float ? 4 : 8;
  PointCloud2 cloud;
  cloud.height = layout.height;
  cloud.width = static_cast<std::uint32_t>(points.size()) / layout.height;
  cloud.is_bigendian = layout.is_bigendian;
  cloud.point_step = layout.before + 3 * size + layout.after;
  cloud.row_step = cloud.width * cloud.point_step + layout.after_row;
  cloud.data.resize(std::size_t{cloud.row_step} * cloud.height, 0x7f);
  for (const char* name : {"z", "x", "y"}) {  // in any order
    PointField& field = cloud.fields.emplace_back();
    field.name = name;
    field.offset = layout.before + static_cast<std::uint32_t>(name[0] - 'x') * size;
    field.datatype = layout.datatype;
    field.count = 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      std::uint8_t* const place =
          cloud.data.data() + (i / cloud.width) * cloud.row_step + (i % cloud.width) * cloud.point_step + field.offset;
      const double value = points[i][name[0] - 'x'];
      is_float ? write<float>(value, layout.is_bigendian, place) : write<double>(value, layout.is_bigendian, place);
    }
  }
  return cloud;
}

const Points kPoints{{1.0, 2.0, 3.0}, {-0.5, 0.25, 8.0}, {0.0, -4.0, 0.125}, {7.0, 7.5, -1.0}};

TEST(TrackedPoints, OfCloudsAreReadInEveryLayout) {
  for (const std::uint8_t datatype : {PointField::FLOAT32, PointField::FLOAT64})
    for (const std::uint32_t beside : {0U, 5U})
      for (const std::uint32_t height : {1U, 2U, 4U})
        for (const bool is_bigendian : {false, true}) {
          const Layout layout{datatype, beside, 2 * beside, height, 3 * beside, is_bigendian};
          EXPECT_EQ(pointsOf(cloudOf(kPoints, layout)), kPoints)
              << "type " << int{datatype} << ", " << beside << " bytes beside, height " << height << ", big-endian "
              << is_bigendian;
        }
}

TEST(TrackedPoints, WithoutAReturnAreLeftOut) {
  Points points = kPoints;
  points[1].y() = kNaN;
  points[2] = {kNaN, kNaN, kNaN};
  EXPECT_EQ(pointsOf(cloudOf(points)), (Points{kPoints[0], kPoints[3]}));
  EXPECT_TRUE(pointsOf(cloudOf({{kNaN, 0.0, 0.0}})).empty());
  EXPECT_TRUE(pointsOf(PointCloud2()).empty()) << "nobody is there, and no field is needed";
}

TEST(SensedPoints, AreAllThatAreFinite) {
  Points points(3000, Vector3d(1.0, 0.0, 0.0));
  points[1].y() = kNaN;
  points[2].z() = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(returnsOf(cloudOf(points)), Points(2998, Vector3d(1.0, 0.0, 0.0)));
  EXPECT_TRUE(returnsOf(PointCloud2()).empty());
}

TEST(TrackedPoints, AreRefusedIfACoordinateIsInfinite) {
  EXPECT_EQ(errorOf([] {
              pointsOf(cloudOf({{0, 0, 0}, {0, std::numeric_limits<double>::infinity(), 0}}));
            }),
            "point 1 is not finite");
}

TEST(TrackedPoints, AreAtMostAThousandWithAReturn) {
  Points points(1000, Vector3d(1.0, 0.0, 0.0));
  points.insert(points.end(), 5000, Vector3d::Constant(kNaN));
  EXPECT_EQ(pointsOf(cloudOf(points)).size(), 1000U);
  points.back().setZero();
  EXPECT_EQ(errorOf([&] { pointsOf(cloudOf(points)); }), "it has more than 1000 points");
}

TEST(TrackedPoints, OfACloudWhoseSizesDoNotFitAreRefused) {
  const auto refusal = [](const auto& spoil) {
    PointCloud2 cloud = cloudOf(kPoints, {PointField::FLOAT32, 0, 0, 2});
    spoil(cloud);
    return errorOf([&] { pointsOf(cloud); });
  };
  const std::string beyond = "row_step times height is more than its data",
                    steps = "width times point_step is more than row_step";
  EXPECT_EQ(refusal([](PointCloud2&) {}), "");
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.data.pop_back(); }), beyond);
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.height = 3; }), beyond);
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.width = 3; }), steps);
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.row_step = 0; }), steps);
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.point_step = 8; }), "its field z ends beyond point_step");
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.point_step = 0; }), "its field x ends beyond point_step");
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.fields[0].offset = 9; }), "its field z ends beyond point_step");
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.fields[1].name = "X"; }), "it has no field x");
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.fields[2].datatype = PointField::INT32; }),
            "its field y is neither FLOAT32 nor FLOAT64");
  // In 32 bits each of these would be small.
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.fields[1].offset = 0xfffffffe; }),
            "its field x ends beyond point_step");
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.width = cloud.point_step = 0x10000; }), steps);
  EXPECT_EQ(refusal([](PointCloud2& cloud) { cloud.row_step = cloud.height = 0x10000; }), beyond);
}

TEST(TrackedPoints, OfPosesAreTheirPositions) {
  geometry_msgs::PoseArray message;
  EXPECT_TRUE(pointsOf(message).empty());
  for (const Vector3d& point : kPoints) {
    geometry_msgs::Point& position = message.poses.emplace_back().position;
    position.x = point.x();
    position.y = point.y();
    position.z = point.z();
  }
  EXPECT_EQ(pointsOf(message), kPoints);
  message.poses[2].position.z = kNaN;
  EXPECT_EQ(errorOf([&] { pointsOf(message); }), "point 2 is not finite") << "a person without a place is somewhere";
  message.poses.resize(1001);
  message.poses[2].position.z = 0.0;
  EXPECT_EQ(errorOf([&] { pointsOf(message); }), "it has more than 1000 points");
}

}  // namespace proximity_server::node::tracked_points_test
