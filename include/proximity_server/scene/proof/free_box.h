#pragma once

#include "proximity_server/scene/proof/joint_box.h"
#include "proximity_server/scene/proof/pair_proof.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <memory>
#include <vector>

namespace proximity_server::scene {

/// A box about a state in which all pairs are proven apart.
struct FreeBox {
  double scale = -1.0;  ///< the box reaches this times the weights from the state; -1: not even the state is proven
  JointBox box;         ///< empty if not even the state is proven
  /// The pairs that were not proven in the smallest box that is not free; empty if the largest one is free.
  std::vector<PairProof> obstacles;
};

struct FreeBoxQuestion {
  ProofQuestion proof;
  double most_scale = 1.0;  ///< above 0
  double accuracy = 0.01;   ///< in (0, 1): relative, of the scale: how near a larger one is that is not proven free
};

/// Finds a large box about a state that is proven free: all states within the limits that differ from `state` by at
/// most scale times `weights`, see boxAbout(). A smaller box of this shape is free if a larger one is, so the scale is
/// bisected.
///
/// Units:   state [rad] or [m]; weights likewise, one for each of RobotModel::joints; 0: the joint is fixed.
/// Error:   the box is proven, whatever the budget is. A larger one may also be free, if `obstacles` are undecided.
/// Failure: throws std::invalid_argument as proveApart() and boxAbout() do, and for numbers of the question that are
///          out of their range.
FreeBox freeBox(const std::shared_ptr<const SceneModel>& model, const std::vector<ShapeRefPair>& pairs,
                const Positions& state, const std::vector<double>& weights, const FreeBoxQuestion& question = {});

}  // namespace proximity_server::scene
