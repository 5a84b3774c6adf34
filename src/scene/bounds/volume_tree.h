#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "scene/bounds/bounds.h"

#include <array>
#include <vector>

namespace proximity_server::scene {

/// Some pieces of one body: a leaf with one piece, or a volume with two parts.
struct Volume {
  int piece = -1;                                         ///< the piece of a leaf
  std::array<int, 2> parts{-1, -1};                       ///< the two volumes that any other volume consists of
  Representation representation = Representation::Exact;  ///< the least exact one of its pieces
  bool has_closed_form = false;                           ///< true for a single sphere or capsule
  bool has_interior = false;                              ///< true if one of its pieces has an interior
  bool has_representative = false;                        ///< true if one of its pieces is a representative
  int wide = -1;                                          ///< the number of its WideVolume; -1: it has none
  Bounds bounds;

  bool isLeaf() const { return piece >= 0; }
  bool isEmpty() const { return piece < 0 && parts[0] < 0; }
};

/// True if a search that refines a pair of volumes splits a rather than b: it splits the larger one of those that have
/// parts.
bool splitsFirst(const Volume& a, const Volume& b);

/// Builds hierarchies of bounding volumes over convex pieces.
class VolumeBuilder {
 public:
  /// `representations` has one entry for each piece. The pieces must outlive the builder.
  VolumeBuilder(const std::vector<Piece>& pieces, std::vector<Representation> representations);

  /// The volume over some pieces of a body. Its parts, and their parts, are appended to `volumes`.
  Volume over(std::vector<int> pieces, std::vector<Volume>& volumes) const;

 private:
  Volume leafOf(int piece) const;
  Volume volumeOf(std::vector<int>::iterator begin, std::vector<int>::iterator end, std::vector<Volume>& volumes) const;
  Bounds boundsOver(std::vector<int>::iterator begin, std::vector<int>::iterator end) const;

  const std::vector<Piece>& pieces_;
  std::vector<Representation> representations_;
  std::vector<Bounds> bounds_of_pieces_;
  bool are_aligned_;  ///< all pieces are boxes along the axes of the body
};

}  // namespace proximity_server::scene
