#pragma once

#include "proximity_server/scene/proof/joint_box.h"
#include "proximity_server/scene/proof/pair_proof.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <memory>
#include <vector>

namespace proximity_server::scene {

/// Decides for each pair whether it can come into contact in a box of joint positions: branch and bound.
///
/// 1. Only the joints between the two bodies matter, and of mimic joints their leaders. So a pair has its own box.
/// 2. At the centre of a box the narrowphase measures the distance. If it is in contact there, the pair is refuted. A
///    corner of the box may also be in contact, see GuaranteedDistances::reached(); that is verified in the same way.
/// 3. The lower bound of the box is computed by GuaranteedDistances with the half widths as the uncertainty of the
///    positions, minus what rounding can do to the kinematics.
/// 4. The box with the smallest bound is halved, along the joint that moves the points of the two the most. (Weighing
///    joints by the derivative of the distance left more pairs undecided.) It ends when all boxes have a bound above
///    the contact distance.
/// 5. If that has not decided, axes fixed to a body may: a certificate is looked for, with a node for every 256
///    boxes, see certify(). Its bounds are exact to first order in each joint, and so decide large boxes.
/// 6. With Goal::Shares a box is in contact everywhere if the upper bound at its centre plus the largest travel of all
///    points (FreeMotion::weights()) is.
///
/// The proof is about the geometry of the model: convex pieces in place of meshes (ModelOptions::mesh_tolerance), and
/// paddings. Objects stand where they are, and those that a link holds or whose frame is a link move with it.
///
/// Pairs are examined in rounds with growing budgets, so that all have a share of the time until a deadline, and in
/// parallel. The result is the same for any number of threads. With a deadline it depends on the time that the system
/// gives to the program: what is proven or refuted is true, but it may be another part.
///
/// Error:   bounds and refuting states hold for the kinematics in real numbers, up to the rounding that the bounds
///          contain, with continuous joints from -pi to pi.
/// Limit:   the number of boxes grows exponentially with the number of joints between the two.
/// Failure: throws std::invalid_argument, with its name, for a floating or planar joint between two bodies of a pair,
///          for a joint between them whose interval is missing, empty or not finite, for a model of several robots, for
///          objects of another model, and for numbers of the question that are out of their range.
std::vector<PairProof> proveApart(const std::shared_ptr<const SceneModel>& model,
                                  const std::vector<ShapeRefPair>& pairs, const JointBox& box,
                                  const ProofQuestion& question = {});

}  // namespace proximity_server::scene
