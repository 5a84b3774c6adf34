#pragma once

#include <array>
#include <vector>

#include "proximity_server/scene/query/question.h"
#include "scene/model/bounds.h"

namespace proximity_server::scene {

/// Some pieces of one body: a leaf (one piece), or two volumes.
struct Volume {
  int body;
  int piece = -1;                                         ///< of a leaf
  std::array<int, 2> parts{-1, -1};                       ///< of all others
  Representation representation = Representation::Exact;  ///< the least exact of its pieces
  bool has_closed_form = false;                           ///< a single sphere or capsule
  Bounds bounds;

  bool isLeaf() const { return piece >= 0; }
  bool isEmpty() const { return piece < 0 && parts[0] < 0; }
};

/// Whether a search that refines a pair of volumes splits a rather than b: the larger of the two that has parts.
bool splitsFirst(const Volume& a, const Volume& b);

/// The <collision> element of a piece (index into RobotModel::pieces).
const Collision& collisionOf(const RobotModel& model, int piece);

/// The links and <collision> elements of a robot as hierarchies of bounding volumes over their pieces.
class Volumes {
 public:
  explicit Volumes(const RobotModel& model);

  const Volume& operator[](int volume) const { return volumes_[volume]; }

  /// Throws std::invalid_argument for a link or <collision> that does not exist.
  int of(const ShapeRef& ref) const;

  /// The volumes that `of` may return are 0 to rootCount() - 1, the links first.
  int rootCount() const { return root_count_; }

 private:
  Volume leafOf(int piece) const;
  Volume volumeOf(int body, std::vector<int>::iterator begin, std::vector<int>::iterator end);
  int add(const Volume& volume);

  const RobotModel& model_;
  std::vector<Bounds> bounds_of_pieces_;
  std::vector<Volume> volumes_;
  int root_count_;
};

}  // namespace proximity_server::scene
