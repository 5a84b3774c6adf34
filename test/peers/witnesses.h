#pragma once

#include "peers/solids.h"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace proximity_server::peers {

/// The points and the normal of a pair for a derivative, in the frame of a: a point on each solid, the normal from a to
/// b.
struct Witnesses {
  Eigen::Vector3d point_a, point_b, normal;
};

/// A library, asked in the way that it offers for this: apart for the nearest points, in overlap for the deepest
/// contact.
struct WitnessLibrary {
  std::string name;
  std::optional<Witnesses> (*ask)(const Solid& a, const Solid& b, const Eigen::Isometry3d& a_T_b, bool are_apart);
};

/// FCL 0.7 with its default solver and with its own one, and Bullet 3.24 in single precision, as Debian packages it.
std::vector<WitnessLibrary> witnessLibraries();

}  // namespace proximity_server::peers
