#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"
#include "proximity_server/scene/scene_model/shape_ref.h"

#include <Eigen/Core>

#include <vector>

namespace proximity_server::scene {

/// A direction that is fixed to the body of a link, in the frame of this body, from a to b, of any length but 0.
struct SeparatingAxis {
  int link;  ///< index into RobotModel::links
  Eigen::Vector3d direction;
};

/// A node of a tree that divides a box of joint positions.
struct CertificateNode {
  int joint = -1;   ///< index into RobotModel::joints; -1: a leaf
  double at = 0.0;  ///< [rad] or [m] where the interval of the joint is divided
  /// Only for a leaf. In all states of its box one of these axes separates each piece of a from each piece of b.
  std::vector<SeparatingAxis> axes = {};
};

/// Evidence that two shapes stay apart in a box of joint positions.
struct PairCertificate {
  ShapeRefPair pair;  ///< whole links and objects
  double bound;       ///< [m] the signed distance of the two, less the padding of the pair, is at least this
  /// In preorder: after a node that divides a box follow the tree of the part below `at` and the tree of the part
  /// above.
  std::vector<CertificateNode> tree;
};

}  // namespace proximity_server::scene
