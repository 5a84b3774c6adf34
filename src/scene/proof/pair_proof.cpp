#include "proximity_server/scene/proof/pair_proof.h"

namespace proximity_server::scene {

const char* toString(ProofOutcome outcome) {
  switch (outcome) {
    case ProofOutcome::Proven:
      return "proven";
    case ProofOutcome::Refuted:
      return "refuted";
    case ProofOutcome::Undecided:
      break;
  }
  return "undecided";
}

}  // namespace proximity_server::scene
