#pragma once

#include <string>
#include <vector>

namespace proximity_server::scene {

/// The reason why a pair of links, or a pair with an object, is checked or not: the first reason that applies, in this
/// order.
enum class PairReason : unsigned char {
  Checked = 0,
  SameBody,  ///< joined by fixed joints only; or an object that is attached to this body; or two objects in one frame
  NotInOnlyPairs,  ///< only_pairs is not empty and does not contain the pair
  ConfigExcluded,  ///< named by exclude_pairs
  SrdfDisabled,    ///< disable_collisions, or disable_default_collisions of one of the two
  Adjacent,    ///< neighbours, see RobotModel::areNeighbours, that neither only_pairs nor enable_collisions asks for
  NotInGroup,  ///< neither link is moved by the chosen group

  // For pairs with an object:
  NoGeometry,      ///< the link has no collision geometry
  BothStatic,      ///< neither of the two moves in the world
  TouchLink,       ///< the attached object may touch the link
  Allowed,         ///< see AllowedPairs
  FreeObjects,     ///< two objects that are not attached, if the rules do not ask for such pairs
  BothHalfSpaces,  ///< both have a half-space, and two half-spaces nearly always meet
};
const char* toString(PairReason reason);

struct LinkPair {
  int link_a, link_b;  ///< link_a < link_b, both with geometry
  PairReason reason;
  std::string detail;  ///< the SRDF's reason attribute, or ""
  double padding = 0;  ///< [m] subtracted from the distance of this pair, half on each side
};

/// An entry without effect in a list of the SRDF or of the configuration.
struct IdleEntry {
  enum class Cause : unsigned char { UnknownLink, NoGeometry, SameBody, Repeated };
  std::string list;  ///< disable_collisions, exclude_pairs, ...
  std::string link_a, link_b;
  Cause cause;  ///< the first cause that applies
};
const char* toString(IdleEntry::Cause cause);

/// All pairs of links with geometry, each with its reason.
struct PairTable {
  std::vector<LinkPair> pairs;  ///< sorted by (link_a, link_b)
  std::vector<int> checked;     ///< indices of the candidate pairs
  /// unknown names (with the nearest known name), and counts of entries without effect
  std::vector<std::string> warnings;
  std::vector<IdleEntry> idle;  ///< the entries without effect, in the order of their lists

  /// The index of the pair, given in either order, or -1.
  int find(int link_a, int link_b) const;
};

}  // namespace proximity_server::scene
