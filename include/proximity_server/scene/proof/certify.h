#pragma once

#include "proximity_server/scene/certificate/certificate.h"
#include "proximity_server/scene/proof/pair_proof.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// Writes a certificate for each proof whose outcome is Proven, in their order; the others have none.
///
/// 1. In the middle of a box the narrowphase tells the axis along which the closest two pieces are apart. It is fixed
///    to the body between the two for which it separates them best in the whole box.
/// 2. As long as two pieces are not separated by one of the axes so far, the narrowphase tells theirs.
/// 3. If their own axis does not separate two pieces, the box is halved, along the joint without whose motion the axis
///    would separate them best.
///
/// flawIn() accepts what it writes: both take the bounds of the same boxes. The bound of a certificate may be smaller
/// than the bound of the proof, but it is above the contact distance. It is a thousandth smaller than what the axes
/// prove, so that computers whose cosines are rounded otherwise accept it, too.
/// `question`: the question of the proofs.
/// most_boxes counts the nodes of each tree; nothing is written where they do not
/// suffice, or once the flag of the deadline is set. Its time does not matter.
/// Failure: throws std::invalid_argument as proveApart() does.
std::vector<std::optional<PairCertificate>> certify(const std::shared_ptr<const SceneModel>& model,
                                                    const std::vector<PairProof>& proofs,
                                                    const ProofQuestion& question = {});

}  // namespace proximity_server::scene
