#pragma once

#include "proximity_server/scene/certificate/certificate.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/proof/pair_proof.h"

#include <atomic>
#include <optional>

namespace proximity_server::scene {

/// A certificate for the pair and the box of `proof`, whatever its outcome is; nullopt if the tree would have more than
/// `most_nodes` nodes, if the deadline has come, or if `is_over`. See certify().
std::optional<PairCertificate> certificateOf(const PairProof& proof, const SceneModel& model,
                                             const ProofQuestion& question, long most_nodes,
                                             const std::atomic<bool>& is_over);

}  // namespace proximity_server::scene
