#include "proximity_server/scene/sensed/octree.h"

#include "proximity_server/scene/sensed/cloud_file.h"

#include "chance.h"
#include "scene/files.h"

#include <gtest/gtest.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>
#include <octomap/OcTreeStamped.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace proximity_server::scene::octree_test {

using Eigen::AlignedBox3d;
using Eigen::Array3d;
using Eigen::Vector3d;

template <class Tree>
std::string bytesOf(const Tree& tree, bool is_binary) {
  std::ostringstream stream;
  is_binary ? tree.writeBinaryData(stream) : tree.writeData(stream);
  return stream.str();
}

template <class Tree>
std::vector<AlignedBox3d> boxesOf(const Tree& tree, bool is_binary) {
  const std::string bytes = bytesOf(tree, is_binary);
  return occupiedBoxes({tree.getTreeType(), is_binary, tree.getResolution(), bytes});
}

octomap::OcTreeKey keyOf(const Eigen::Array3i& voxel) {
  const Eigen::Array3i key = voxel + 32768;
  return {static_cast<octomap::key_type>(key.x()), static_cast<octomap::key_type>(key.y()),
          static_cast<octomap::key_type>(key.z())};
}

/// A tree with cubes of voxels of one occupancy, and single voxels of any.
template <class Tree>
Tree randomTree(Chance& chance, double resolution) {
  Tree tree(resolution);
  for (int i = 0; i < 40; ++i) {
    const int edge = i % 4 == 0 ? 1 << chance.below(4) : 1, reach = i % 2 == 0 ? 16 : 32768 - 8;
    const float log_odds = std::clamp(static_cast<float>(chance.between(-4.0, 4.0)), -2.0F, 3.5F);
    Eigen::Array3i corner;
    for (int axis = 0; axis < 3; ++axis) corner[axis] = (chance.below(2 * reach) - reach) / edge * edge;
    for (int x = 0; x < edge; ++x)
      for (int y = 0; y < edge; ++y)
        for (int z = 0; z < edge; ++z)
          tree.setNodeValue(keyOf(corner + Eigen::Array3i(x, y, z)), log_odds, /*lazy_eval=*/true);
  }
  tree.updateInnerOccupancy();
  return tree;
}

/// Each occupied leaf of octomap is in one box, and the boxes have their volume together.
template <class Tree>
void expectTheOccupiedLeaves(const Tree& tree, const std::vector<AlignedBox3d>& boxes) {
  double volume = 0.0, volume_of_boxes = 0.0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const double size = tree.getNodeSize(leaf.getDepth());
    const Vector3d centre(leaf.getX(), leaf.getY(), leaf.getZ()), half = Vector3d::Constant(0.5 * size);
    const AlignedBox3d cube(centre - half * (1.0 - 1e-9), centre + half * (1.0 - 1e-9));
    const bool is_occupied = tree.isNodeOccupied(*leaf);
    const auto has = [&](const AlignedBox3d& box) { return is_occupied ? box.contains(cube) : box.contains(centre); };
    ASSERT_EQ(std::count_if(boxes.begin(), boxes.end(), has), is_occupied ? 1 : 0) << centre.transpose();
    if (is_occupied) volume += std::pow(size, 3);
  }
  for (const AlignedBox3d& box : boxes) volume_of_boxes += box.volume();
  EXPECT_NEAR(volume_of_boxes, volume, 1e-9 * volume);
}

template <class Tree>
void expectSameAsOctomap(unsigned seed) {
  Chance chance(seed);
  for (const double resolution : {0.01, 0.05, 0.7}) {
    for (int i = 0; i < 20; ++i) {
      Tree tree = randomTree<Tree>(chance, resolution);
      for (const bool is_binary : {true, false}) {
        const std::vector<AlignedBox3d> boxes = boxesOf(tree, is_binary);
        expectTheOccupiedLeaves(tree, boxes);
        Tree pruned(tree);
        pruned.prune();
        EXPECT_LT(pruned.size(), tree.size());
        const std::vector<AlignedBox3d> of_pruned = boxesOf(pruned, is_binary);
        ASSERT_EQ(of_pruned.size(), boxes.size());
        for (std::size_t k = 0; k < boxes.size(); ++k) EXPECT_TRUE(of_pruned[k].isApprox(boxes[k], 0.0));
      }
    }
  }
}

TEST(Octree, HasTheOccupiedLeavesOfOctomap) {
  expectSameAsOctomap<octomap::OcTree>(1);
  expectSameAsOctomap<octomap::ColorOcTree>(2);
  expectSameAsOctomap<octomap::OcTreeStamped>(3);
}

/// The bytes of the way to the voxel with a corner at the origin.
std::string voxelAtOrigin() {
  using std::string_literals::operator""s;
  std::string bytes = "\x00\xC0"s;
  for (int level = 1; level < 15; ++level) bytes += "\x03\x00"s;
  return bytes + "\x02\x00"s;
}

TEST(Octree, HasTheVoxelAtTheOrigin) {
  const std::string bytes = voxelAtOrigin();
  const std::vector<AlignedBox3d> boxes = occupiedBoxes({"OcTree", true, 0.1, bytes});
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_TRUE(boxes[0].contains(AlignedBox3d(Vector3d::Zero(), Vector3d::Constant(0.1))));
  EXPECT_LT(boxes[0].sizes().maxCoeff(), 0.1 + 1e-15);
  EXPECT_TRUE(occupiedBoxes({"OcTree", true, 0.1, ""}).empty());
  EXPECT_TRUE(occupiedBoxes({"OcTree", false, 0.1, ""}).empty());
}

/// Rounding puts some of these points into the voxel beside theirs.
TEST(Octree, ContainsThePointsOnTheCornersOfVoxels) {
  for (const double resolution : {0.02, 0.1, 0.7}) {
    octomap::OcTree tree(resolution);
    std::vector<Vector3d> points;
    for (int i = -2000; i < 2000; i += 9) {
      const double corner = resolution * i;
      points.emplace_back(corner, std::nextafter(corner, 1e9), std::nextafter(corner, -1e9));
    }
    for (const Vector3d& point : points) tree.setNodeValue(tree.coordToKey(point.x(), point.y(), point.z()), 1.0F);
    const std::vector<AlignedBox3d> boxes = boxesOf(tree, true);
    for (const Vector3d& point : points)
      EXPECT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const AlignedBox3d& box) { return box.contains(point); }))
          << point.transpose();
  }
}

/// Boxes of octomap's files are those of their bytes.
TEST(Octree, IsReadFromTheFilesOfOctomap) {
  Chance chance(6);
  const TemporaryFiles files;
  auto tree = randomTree<octomap::ColorOcTree>(chance, 0.05);
  for (const std::string name : {"map.bt", "map.ot"}) {
    const bool is_binary = name == "map.bt";
    const std::string path = files.path(name);
    ASSERT_TRUE(is_binary ? tree.writeBinary(path) : tree.write(path));
    const std::vector<AlignedBox3d> boxes = readCloudBoxes(path, 0.02), expected = boxesOf(tree, is_binary);
    ASSERT_EQ(boxes.size(), expected.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) EXPECT_TRUE(boxes[i].isApprox(expected[i], 0.0));

    const std::string content = readFile(path), cut = files.write("cut." + name, content.substr(0, content.size() - 1));
    EXPECT_NE(errorOf([&] { readCloudBoxes(cut, 0.02); }).find("the octree ends in the middle of a node"),
              std::string::npos);
  }
  const std::string empty = files.write("empty.bt", "# Octomap OcTree binary file\nid OcTree\nsize 0\nres 0.1\ndata\n");
  EXPECT_EQ(errorOf([&] { readCloudBoxes(empty, 0.02); }), empty + ": nothing is occupied");
  const std::string other = files.write("other.bt", "OCTREE 1\n");
  EXPECT_EQ(errorOf([&] { readCloudBoxes(other, 0.02); }),
            other + ", line 1: no octree of octomap: it does not begin with \"# Octomap OcTree\"");
  const std::string no_data = files.write("no_data.ot", "# Octomap OcTree file\nid OcTree\nres 0.1\n");
  EXPECT_EQ(errorOf([&] { readCloudBoxes(no_data, 0.02); }), no_data + ", line 3: the file ends in its header");
}

std::string errorFor(const std::string& bytes, bool is_binary = true, const std::string& id = "OcTree") {
  return errorOf([&] { occupiedBoxes({id, is_binary, 0.1, bytes}); });
}

TEST(Octree, RefusesEveryTruncationAndWhatFollows) {
  Chance chance(4);
  const auto tree = randomTree<octomap::ColorOcTree>(chance, 0.1);
  for (const bool is_binary : {true, false}) {
    const std::string bytes = bytesOf(tree, is_binary);
    for (std::size_t size = 1; size < bytes.size(); ++size)
      ASSERT_NE(errorFor(bytes.substr(0, size), is_binary, "ColorOcTree").find("ends in the middle of a node"),
                std::string::npos);
    EXPECT_EQ(errorFor(bytes + '\0', is_binary, "ColorOcTree"),
              "byte " + std::to_string(bytes.size()) + ": the octree is complete, and more bytes follow");
  }
}

TEST(Octree, RefusesWhatIsTooDeepOrTooMuch) {
  std::string binary, full, node("\x00\x00\x80\x3F\x01", 5);
  for (int level = 0; level < 100; ++level) binary += std::string("\x03\x00", 2), full += node;
  EXPECT_EQ(errorFor(binary), "byte 34: the octree has more than 16 levels");
  EXPECT_EQ(errorFor(full, false), "byte 85: the octree has more than 16 levels");

  std::string free = "\x55\x55";  // 8^8 leaves
  for (int level = 1; level < 8; ++level) {
    std::string above = "\xFF\xFF";
    for (int i = 0; i < 8; ++i) above += free;
    free = above;
  }
  EXPECT_NE(errorFor(free).find("the octree has more than 10000000 nodes"), std::string::npos);
}

TEST(Octree, RefusesNodesWithoutSense) {
  EXPECT_EQ(errorFor(std::string(2, '\0')), "byte 2: a node has no children");
  EXPECT_EQ(errorFor(std::string("\x00\x00\xC0\x7F\x00", 5), false), "byte 4: the log-odds of a node are NaN");
  EXPECT_EQ(errorFor("", false, "CountingOcTree"),
            "an octree of class \"CountingOcTree\" is not supported; OcTree, OcTreeStamped and ColorOcTree are");
  for (const double resolution : {0.0, -0.1, std::nan(""), 1e305, std::numeric_limits<double>::infinity()})
    EXPECT_EQ(errorOf([&] {
                occupiedBoxes({"OcTree", true, resolution, ""});
              }),
              "the resolution of an octree must be a positive number");
}

TEST(Octree, TakesOrRefusesRandomBytes) {
  Chance chance(5);
  int taken = 0, refused = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = i % 2 == 0 ? voxelAtOrigin() : std::string(static_cast<std::size_t>(chance.below(60)), '\0');
    for (int k = 0; k < (i % 2 == 0 ? 2 : 60) && !bytes.empty(); ++k)
      bytes[static_cast<std::size_t>(chance.below(static_cast<int>(bytes.size())))] =
          static_cast<char>(chance.below(256));
    ++(errorFor(bytes, i % 4 < 2).empty() ? taken : refused);
  }
  EXPECT_GT(taken, 200);
  EXPECT_GT(refused, 2000);
}

}  // namespace proximity_server::scene::octree_test
