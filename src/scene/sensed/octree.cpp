#include "proximity_server/scene/sensed/octree.h"

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/sensed/voxel_grid.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Array3i;

constexpr int kLevels = 16;  // octomap has no other octrees
constexpr int kChildren = 8;

/// A cube of the octree, in smallest leaves; the centre of the root is the origin.
struct Cube {
  int level = 0;  ///< that of the root is 0
  Array3i corner = Array3i::Constant(-(1 << (kLevels - 1)));

  int edge() const { return 1 << (kLevels - level); }
  Cube child(int number) const {
    return {level + 1, corner + edge() / 2 * Array3i(number & 1, number >> 1 & 1, number >> 2 & 1)};
  }
};

class OctreeReader {
 public:
  explicit OctreeReader(const Octree& octree) : octree_(octree), bytes_of_colour_(octree.id == "ColorOcTree" ? 3 : 0) {
    if (octree.id != "OcTree" && octree.id != "OcTreeStamped" && octree.id != "ColorOcTree")
      throw std::invalid_argument("an octree of class " + quoted(octree.id) +
                                  " is not supported; OcTree, OcTreeStamped and ColorOcTree are");
    if (!(octree.resolution > 0.0) || !std::isfinite(octree.resolution * (1 << kLevels)))
      throw std::invalid_argument("the resolution of an octree must be a positive number");
  }

  std::vector<AlignedBox3d> read() {
    if (octree_.bytes.empty()) return {};
    if (isOccupied(Cube{})) add(Cube{});
    if (next_ != octree_.bytes.size()) fail("the octree is complete, and more bytes follow");
    return std::move(boxes_);
  }

 private:
  struct Node {
    unsigned children;  ///< two bits for each: 0 is unknown, 1 a free leaf, 2 an occupied leaf, 3 a node that follows
    bool is_occupied_leaf;  ///< without children
  };

  bool isOccupied(const Cube& cube);
  Node nextNode();
  void add(const Cube& cube);

  template <class Number>
  Number next() {
    if (octree_.bytes.size() - next_ < sizeof(Number)) fail("the octree ends in the middle of a node");
    Number number;
    std::memcpy(&number, octree_.bytes.data() + next_, sizeof(Number));
    next_ += sizeof(Number);
    return number;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw std::invalid_argument("byte " + std::to_string(next_) + ": " + what);
  }

  const Octree& octree_;
  const int bytes_of_colour_;  // of a node, if the octree is not binary
  std::size_t next_ = 0, nodes_ = 1;
  std::vector<AlignedBox3d> boxes_;
};

/// Reads a node with all that is below it. Returns whether all of it is occupied; otherwise adds what is occupied of it.
bool OctreeReader::isOccupied(const Cube& cube) {
  const auto [children, is_occupied_leaf] = nextNode();
  if (children == 0) return is_occupied_leaf;
  if (cube.level == kLevels) fail("the octree has more than 16 levels");
  unsigned occupied = 0;
  for (int i = 0; i < kChildren; ++i) {
    const unsigned child = children >> (2 * i) & 3U;
    if (child != 0 && ++nodes_ > kMostOctreeNodes)
      fail("the octree has more than " + std::to_string(kMostOctreeNodes) + " nodes");
    if (child == 2U || (child == 3U && isOccupied(cube.child(i)))) occupied |= 1U << i;
  }
  if (occupied == 0xFFU) return true;
  for (int i = 0; i < kChildren; ++i)
    if ((occupied >> i & 1U) != 0) add(cube.child(i));
  return false;
}

OctreeReader::Node OctreeReader::nextNode() {
  if (octree_.is_binary) {
    const unsigned first = next<std::uint8_t>(), children = first | next<std::uint8_t>() << 8U;
    if (children == 0) fail("a node has no children");
    return {children, false};
  }
  const auto log_odds = next<float>();
  if (std::isnan(log_odds)) fail("the log-odds of a node are NaN");
  for (int i = 0; i < bytes_of_colour_; ++i) next<std::uint8_t>();
  const unsigned following = next<std::uint8_t>();
  unsigned children = 0;
  for (int i = 0; i < kChildren; ++i) children |= (following >> i & 1U) * (3U << (2 * i));
  return {children, log_odds >= 0.0F};
}

void OctreeReader::add(const Cube& cube) {
  boxes_.push_back(VoxelGrid::box(cube.corner, cube.corner + cube.edge(), octree_.resolution));
}

}  // namespace

std::vector<AlignedBox3d> occupiedBoxes(const Octree& octree) { return OctreeReader(octree).read(); }

}  // namespace proximity_server::scene
