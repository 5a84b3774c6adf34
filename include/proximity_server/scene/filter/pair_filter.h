#pragma once

#include <string>
#include <utility>
#include <vector>

#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// Why a pair of links, or of an object and another one or a link, is checked or not: the first reason that applies, in
/// this order.
enum class PairReason : unsigned char {
  Checked = 0,
  SameBody,        ///< joined by fixed joints only; an object that is attached to this body, or two in one frame
  NotInOnlyPairs,  ///< only_pairs is not empty and does not contain the pair
  ConfigExcluded,  ///< named by exclude_pairs
  SrdfDisabled,    ///< disable_collisions, or disable_default_collisions of one of the two
  Adjacent,    ///< neighbours, see RobotModel::areNeighbours, that neither only_pairs nor enable_collisions asks for
  NotInGroup,  ///< neither link is moved by the chosen group

  // Of pairs with an object:
  NoGeometry,      ///< the link has no collision geometry
  BothStatic,      ///< neither moves in the world
  TouchLink,       ///< the attached object may touch the link
  Allowed,         ///< see AllowedPairs
  FreeObjects,     ///< two objects that are not attached, and the rules do not ask for them
  BothHalfSpaces,  ///< both have a half-space, and these always meet
};
const char* toString(PairReason reason);

struct LinkPair {
  int link_a, link_b;  ///< link_a < link_b, both with geometry
  PairReason reason;
  std::string detail;  ///< the SRDF's reason attribute, or ""
  double padding = 0;  ///< [m] taken off the distance of this pair, half on each side
};

/// An entry without effect in a list of the SRDF or of the configuration.
struct IdleEntry {
  enum class Cause : unsigned char { UnknownLink, NoGeometry, SameBody, Repeated };
  std::string list;  ///< disable_collisions, exclude_pairs, ...
  std::string link_a, link_b;
  Cause cause;  ///< the first that applies
};
const char* toString(IdleEntry::Cause cause);

/// All pairs of links with geometry, each with its reason.
struct PairTable {
  std::vector<LinkPair> pairs;        ///< sorted by (link_a, link_b)
  std::vector<int> checked;           ///< indices of the candidate pairs
  std::vector<std::string> warnings;  ///< unknown names (with the nearest known one), and counts of useless entries
  std::vector<IdleEntry> idle;        ///< those entries, in the order of their lists

  /// Index of the pair in either order, or -1.
  int find(int link_a, int link_b) const;
};

struct PairFilterOptions {
  using Names = std::pair<std::string, std::string>;
  std::vector<Names> exclude_pairs;
  std::vector<Names> only_pairs;  ///< empty: no restriction
  std::string group;              ///< of the SRDF; empty: no restriction
  std::vector<std::pair<Names, double>> pair_padding;
};

/// Decides which pairs of links are checked: all but those of one body, neighbours, and what SRDF or options leave out.
///
/// `srdf_xml` may be empty. disable_collisions, enable_collisions, disable_default_collisions and groups (links,
/// joints, chains, subgroups) count. An enable_collisions brings back what disable_default_collisions or adjacency
/// took, but yields to a disable_collisions of the same pair.
/// Failure: throws std::invalid_argument for XML that cannot be read, for a group that does not exist or contains
///          itself, and for a link of the options that does not exist. Names of the SRDF that do not exist, duplicates
///          and entries without effect become warnings, and so do neighbours that are left out silently or checked.
PairTable filterPairs(const RobotModel& model, const std::string& srdf_xml, const PairFilterOptions& options = {});

/// The same with an SRDF for each of RobotModel::robots. Each is about its own robot alone, whose links, joints and groups
/// have the names there that they have in the robot's URDF; the options have the names of the model ("left/elbow", and the
/// group "left/arm"). So the pairs of two robots are checked unless the options leave them out.
/// Failure: as above, naming the robot; throws std::invalid_argument also if there is not one SRDF for each robot.
PairTable filterPairs(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                      const PairFilterOptions& options = {});

/// Whether each of RobotModel::bodies moves when the joints of an SRDF group do, those that mimic them included.
/// Failure: throws std::invalid_argument as filterPairs() does, and for a group that does not exist.
std::vector<bool> bodiesMovedBy(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                                const std::string& group);

}  // namespace proximity_server::scene
