#pragma once

#include "proximity_server/scene/proof/prove_apart.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The answer of the tool prove, and what it is about.
struct ProofReport {
  std::shared_ptr<const scene::SceneModel> model;
  scene::JointBox box;
  scene::ProofQuestion question;
  std::vector<scene::PairProof> proofs;
  /// [rad] or [m] How far the box reaches from a state, if the largest one was asked for; and the pairs that were not
  /// proven in a box that is 1 % larger.
  std::optional<double> reach{};
  std::vector<scene::PairProof> beyond{};

  int count(scene::ProofOutcome outcome) const;
  bool isProven() const { return count(scene::ProofOutcome::Proven) == static_cast<int>(proofs.size()); }
};

/// Tables for people: what the proof is about, then the pairs of each outcome.
std::string proofText(const ProofReport& report);

/// The report as one object of JSON, with all digits; infinite numbers are null.
std::string proofJson(const ProofReport& report);

/// The states of all refuted pairs as CSV, which clearance takes as --states; a row for each, in their order. Joints
/// that do not matter to a pair are in the middle of their interval.
std::string refutingStates(const ProofReport& report);

}  // namespace proximity_server::tools
