#pragma once

#include "proximity_server/scene/certificate/certificate.h"
#include "proximity_server/scene/proof/pair_proof.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <optional>

namespace proximity_server::scene {

/// A certificate for the pair and the box of `proof`, whatever its outcome is; nullopt if the tree would have more than
/// `most_nodes` nodes, or if the deadline has come. See certify().
std::optional<PairCertificate> certificateOf(const PairProof& proof, const SceneModel& model,
                                             const ProofQuestion& question, long most_nodes);

}  // namespace proximity_server::scene
