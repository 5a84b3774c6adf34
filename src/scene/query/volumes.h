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

const Collision& collisionOf(const RobotModel& model, int piece);

/// The links and <collision> elements of a robot as hierarchies of bounding volumes over their pieces.
class Volumes {
 public:
  explicit Volumes(const RobotModel& model);

  const Volume& operator[](int volume) const { return volumes_[static_cast<std::size_t>(volume)]; }

  /// Throws std::invalid_argument for a link or <collision> that does not exist.
  int of(const ShapeRef& subject) const;

  /// The volumes that `of` may return are 0 to subjects() - 1, the links first.
  int subjects() const { return subjects_; }

 private:
  Volume leafOf(int piece) const;
  Volume volumeOf(int body, std::vector<int>::iterator begin, std::vector<int>::iterator end);
  int add(const Volume& volume);

  const RobotModel& model_;
  std::vector<Bounds> bounds_of_pieces_;
  std::vector<Volume> volumes_;
  int subjects_;
};

}  // namespace proximity_server::scene
