#include "proximity_server/scene/sensed/cloud_file.h"

#include "chance.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene::cloud_file_test {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

class CloudFile : public testing::Test {
 protected:
  std::vector<Vector3d> pointsOf(const std::string& name, const std::string& content) {
    return readCloudPoints(files_.write(name, content));
  }

  /// The error for a file, without the name of its folder.
  std::string errorFor(const std::string& name, const std::string& content) {
    const std::string path = files_.write(name, content);
    const std::string error = errorOf([&] { readCloudBoxes(path, 0.02); }),
                      folder = path.substr(0, path.size() - name.size());
    return error.rfind(folder, 0) == 0 ? error.substr(folder.size()) : error;
  }

  TemporaryFiles files_;
};

const std::string kPcd =
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS rgb x _ y z\nSIZE 4 4 1 4 4\nTYPE U F U F F\n"
    "COUNT 1 1 3 1 1\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n"
    "255 1.5 0 0 0 -2 0.25\r\n0 nan 0 0 0 1 1\n\n7 1e-3 0 0 0 4 5\n8 1 2 3 4 inf 6";

const std::string kPly =
    "ply\nformat ascii 1.0\ncomment element face 3\nelement vertex 2\nproperty uchar red\nproperty double z\n"
    "property float x\nproperty float y\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "255 0.25 1.5 -2\n0 5 1e-3 4\n3 0 1 0\n";

void expectTheTwo(const std::vector<Vector3d>& points) {
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0], Vector3d(1.5, -2.0, 0.25));
  EXPECT_EQ(points[1], Vector3d(1e-3, 4.0, 5.0));
}

TEST_F(CloudFile, HasThePointsOfTextsThatAreFinite) {
  expectTheTwo(pointsOf("cloud.pcd", kPcd));
  expectTheTwo(pointsOf("cloud.ply", kPly));
}

template <class Number>
std::string bytesOf(double value, bool is_big_endian) {
  const auto number = static_cast<Number>(value);
  std::string bytes(reinterpret_cast<const char*>(&number), sizeof number);
  if (is_big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// A type of number in both formats, for a machine of little endian.
struct NumberType {
  std::string pcd_type, ply_name;
  int size;
  std::string (*bytes)(double, bool);
};
const std::vector<NumberType> kTypes{
    {"I", "char", 1, bytesOf<std::int8_t>},   {"U", "uint8", 1, bytesOf<std::uint8_t>},
    {"I", "int16", 2, bytesOf<std::int16_t>}, {"U", "ushort", 2, bytesOf<std::uint16_t>},
    {"I", "int", 4, bytesOf<std::int32_t>},   {"U", "uint32", 4, bytesOf<std::uint32_t>},
    {"F", "float32", 4, bytesOf<float>},      {"F", "double", 8, bytesOf<double>},
    {"I", "", 8, bytesOf<std::int64_t>},      {"U", "", 8, bytesOf<std::uint64_t>}};

std::string binaryPcd(const NumberType& type, const std::vector<Vector3d>& points) {
  const std::string size = std::to_string(type.size), count = std::to_string(points.size());
  std::string file = "FIELDS z y pad x\nSIZE " + size + " " + size + " 2 " + size + "\nTYPE " + type.pcd_type + " " +
                     type.pcd_type + " U " + type.pcd_type + "\nWIDTH " + count + "\nHEIGHT 1\nPOINTS " + count +
                     "\nDATA binary\n";
  for (const Vector3d& p : points)
    file += type.bytes(p.z(), false) + type.bytes(p.y(), false) + "##" + type.bytes(p.x(), false);
  return file;
}

std::string binaryPly(const NumberType& type, bool is_big_endian, const std::vector<Vector3d>& points) {
  const std::string property = "property " + type.ply_name;
  std::string file = std::string("ply\nformat binary_") + (is_big_endian ? "big" : "little") +
                     "_endian 1.0\nelement vertex " + std::to_string(points.size()) + "\n" + property +
                     " y\nproperty short quality\n" + property + " x\n" + property + " z\nend_header\n";
  for (const Vector3d& p : points)
    file +=
        type.bytes(p.y(), is_big_endian) + "##" + type.bytes(p.x(), is_big_endian) + type.bytes(p.z(), is_big_endian);
  return file + "faces";
}

TEST_F(CloudFile, HasThePointsOfAllTypesOfNumbers) {
  for (const NumberType& type : kTypes) {
    SCOPED_TRACE(type.pcd_type + std::to_string(type.size));
    const double sign = type.pcd_type == "U" ? 1.0 : -1.0;
    const double large = type.pcd_type == "F" ? 0.375 : std::ldexp(1.0, std::min(8 * type.size - 2, 50));
    const std::vector<Vector3d> points{{1.0, sign * 2.0, 3.0}, {sign * 100.0, 0.0, large}};
    EXPECT_EQ(pointsOf("cloud.pcd", binaryPcd(type, points)), points);
    if (type.ply_name.empty()) continue;
    for (const bool is_big_endian : {false, true})
      EXPECT_EQ(pointsOf("cloud.ply", binaryPly(type, is_big_endian, points)), points);
  }
}

TEST_F(CloudFile, LeavesPointsOutThatAreNoReturns) {
  const std::vector<Vector3d> points{{std::nan(""), 0.0, 0.0}, {1.0, 2.0, 3.0}, {0.0, 0.0, -INFINITY}};
  for (const std::string name : {"cloud.pcd", "cloud.ply"}) {
    const std::vector<Vector3d> read =
        pointsOf(name, name == "cloud.pcd" ? binaryPcd(kTypes[6], points) : binaryPly(kTypes[7], true, points));
    EXPECT_EQ(read, std::vector<Vector3d>{points[1]});
  }
  EXPECT_EQ(errorFor("cloud.pcd", binaryPcd(kTypes[6], {points[0]})), "cloud.pcd: nothing is occupied");
  EXPECT_EQ(errorFor("cloud.pcd", binaryPcd(kTypes[6], {})), "cloud.pcd: nothing is occupied");
}

TEST_F(CloudFile, HasVoxelsAboutThePoints) {
  Chance chance(1);
  std::vector<Vector3d> points;
  for (int i = 0; i < 300; ++i) points.emplace_back(chance.pose(1.0).translation());
  const std::vector<AlignedBox3d> boxes = readCloudBoxes(files_.write("cloud.pcd", binaryPcd(kTypes[7], points)), 0.1);
  for (const Vector3d& point : points)
    EXPECT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const AlignedBox3d& box) { return box.contains(point); }));
  EXPECT_LE(boxes.size(), points.size());
  EXPECT_EQ(errorFor("cloud.pcd", binaryPcd(kTypes[7], {{1e9, 0.0, 0.0}})),
            "cloud.pcd: a point is not finite, or too far for the resolution of its voxels");
}

/// Of a text, what is cut off in its last number cannot be seen.
TEST_F(CloudFile, RefusesTruncations) {
  Chance chance(3);
  const std::vector<Vector3d> points{{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
  const std::string ply = binaryPly(kTypes[6], false, points);
  const std::vector<std::pair<std::string, std::string>> whole{
      {"cloud.pcd", kPcd.substr(0, kPcd.size() - 2)},
      {"cloud.pcd", binaryPcd(kTypes[6], points)},
      {"cloud.ply", kPly.substr(0, kPly.find("\n3 0 1 0") - 1)},
      {"cloud.ply", ply.substr(0, ply.size() - 5)}};
  for (const auto& [name, content] : whole)
    for (std::size_t size = 0; size < content.size(); size += 1 + static_cast<std::size_t>(chance.below(8)))
      EXPECT_NE(errorFor(name, content.substr(0, size)), "") << size << " of\n" << content;
}

/// `from` in the text is replaced by `to`.
std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST_F(CloudFile, NamesTheLineAndTheReason) {
  const std::vector<std::pair<std::string, std::string>> pcds{
      {changed(kPcd, "DATA ascii", "DATA binary_compressed"),
       "line 11: DATA binary_compressed is not supported; pcl_convert_pcd_ascii_binary makes a binary file of it"},
      {changed(kPcd, "DATA ascii", "DATA text"), "line 11: DATA is neither ascii nor binary"},
      {changed(kPcd, "TYPE U F", "TYPE U"),
       "line 11: FIELDS, SIZE, TYPE and COUNT of the header differ in their numbers of words"},
      {changed(kPcd, "TYPE U F", "TYPE U Q"), "line 11: a field of TYPE \"Q\" and SIZE 4 is not supported"},
      {changed(kPcd, "SIZE 4 4", "SIZE 4 2"), "line 11: a field of TYPE \"F\" and SIZE 2 is not supported"},
      {changed(kPcd, "SIZE 4 4", "SIZE 4 -4"), "line 11: \"-4\" is no whole number"},
      {changed(kPcd, "COUNT 1 1", "COUNT 1 0"), "line 11: the points have no x"},
      {changed(kPcd, "y z", "y w"), "line 11: the points have no z"},
      {changed(kPcd, "WIDTH 2\n", ""), "line 10: the header has no number WIDTH"},
      {changed(kPcd, "WIDTH 2", "WIDTH 3"), "line 11: POINTS of the header is not WIDTH times HEIGHT"},
      {changed(kPcd, "1.5", "1,5"), "line 12: \"1,5\" is no number"},
      {changed(kPcd, "7 1e-3", "1e-3"), "line 15: 6 numbers, expected 7"},
      {changed(kPcd, "7 1e-3 0 0 0 4 5\n", ""), "line 15: the file ends after 3 of 4 points"},
      {kPcd + "\n\n1 2 3 4 5 6 7", "line 18: more follows behind the points"},
      {kPcd.substr(0, kPcd.find("DATA")), "line 10: the file ends in its header"},
      {changed(kPcd, "DATA ascii", "DATA binary"), "line 11: behind it are 72 bytes, but 4 points have 19 bytes each"}};
  for (const auto& [content, error] : pcds) EXPECT_EQ(errorFor("a.pcd", content), "a.pcd, " + error);
  const std::vector<std::pair<std::string, std::string>> plys{
      {changed(kPly, "ply", "PLY"), "line 1: no PLY: it does not begin with ply"},
      {changed(kPly, "ascii", "text"),
       "line 11: the format is none of ascii, binary_little_endian and binary_big_endian"},
      {changed(kPly, "element vertex", "element camera 1\nelement vertex"),
       "line 4: vertex must be the first element, and no other"},
      {changed(kPly, "element face 1", "element vertex 1"), "line 9: vertex must be the first element, and no other"},
      {changed(kPly, "uchar red", "list uchar int red"),
       "line 5: a property of a vertex of type \"list\" is not supported"},
      {changed(kPly, "vertex 2", "vertex -2"), "line 4: \"-2\" is no whole number"},
      {changed(kPly, "float x", "float u"), "line 11: the points have no x"},
      {changed(changed(kPly, "ascii", "binary_big_endian"), "vertex 2", "vertex 3"),
       "line 11: behind it are 35 bytes, but 3 points have 17 bytes each"}};
  for (const auto& [content, error] : plys) EXPECT_EQ(errorFor("a.ply", content), "a.ply, " + error);
  EXPECT_EQ(errorFor("a.xyz", "1 2 3"), "a.xyz: the name of a cloud ends with .pcd, .ply, .bt or .ot");
  EXPECT_NE(errorOf([] { readCloudBoxes("/nowhere/a.pcd", 0.1); }).find("/nowhere/a.pcd: cannot be read"),
            std::string::npos);
}

/// Files whose numbers of points lie: no memory is taken for what is not there.
TEST_F(CloudFile, RefusesNumbersOfPointsThatAreNotThere) {
  const std::string many = "WIDTH 4294967295\nHEIGHT 4294967295\nPOINTS 4294967295\n";
  EXPECT_NE(errorFor("a.pcd", changed(kPcd, "WIDTH 2\nHEIGHT 2\n", many)), "");
  const std::string binary = binaryPcd(kTypes[6], {{1.0, 2.0, 3.0}});
  EXPECT_EQ(errorFor("a.pcd",
                     changed(binary, "WIDTH 1\nHEIGHT 1\nPOINTS 1", "WIDTH 4294967295\nHEIGHT 1\nPOINTS 4294967295")),
            "a.pcd, line 7: behind it are 14 bytes, but 4294967295 points have 14 bytes each");
}

TEST_F(CloudFile, TakesOrRefusesChangedBytes) {
  Chance chance(2);
  const std::vector<Vector3d> points{{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
  const std::vector<std::pair<std::string, std::string>> whole{{"cloud.pcd", kPcd},
                                                               {"cloud.pcd", binaryPcd(kTypes[6], points)},
                                                               {"cloud.ply", kPly},
                                                               {"cloud.ply", binaryPly(kTypes[6], true, points)}};
  int taken = 0, refused = 0;
  for (int i = 0; i < 500; ++i) {
    auto [name, content] = chance.oneOf(whole);
    for (int k = chance.below(4); k >= 0; --k)
      content[static_cast<std::size_t>(chance.below(static_cast<int>(content.size())))] =
          static_cast<char>(chance.below(256));
    ++(errorFor(name, content).empty() ? taken : refused);
  }
  EXPECT_GT(taken, 50);
  EXPECT_GT(refused, 100);
}

}  // namespace proximity_server::scene::cloud_file_test
