#include "proximity_server/scene/proof/free_box.h"

#include "proximity_server/scene/proof/prove_apart.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kSmallestShare = 1e-6;  // of the largest scale: below it only the state itself is tried

/// The pairs that are not proven.
std::vector<PairProof> obstaclesOf(std::vector<PairProof> proofs) {
  proofs.erase(std::remove_if(proofs.begin(), proofs.end(),
                              [](const PairProof& proof) { return proof.outcome == ProofOutcome::Proven; }),
               proofs.end());
  return proofs;
}

}  // namespace

FreeBox freeBox(const std::shared_ptr<const SceneModel>& model, const std::vector<ShapeRefPair>& pairs,
                const Positions& state, const std::vector<double>& weights, const FreeBoxQuestion& question) {
  const RobotModel& robot = given(model).robot;
  if (!(question.most_scale > 0.0) || !std::isfinite(question.most_scale))
    throw std::invalid_argument("the largest scale of a free box must be finite and above 0");
  if (!(question.accuracy > 0.0 && question.accuracy < 1.0))
    throw std::invalid_argument("the accuracy of a free box must be above 0 and below 1");
  FreeBox free;
  const auto isFree = [&](double scale) {
    std::vector<double> radii = weights;
    for (double& radius : radii) radius *= scale;
    JointBox box = boxAbout(robot, state, radii);
    std::vector<PairProof> obstacles = obstaclesOf(proveApart(model, pairs, box, question.proof));
    if (!obstacles.empty()) {
      free.obstacles = std::move(obstacles);
      return false;
    }
    free.scale = scale;
    free.box = std::move(box);
    return true;
  };
  if (!isFree(0.0) || isFree(question.most_scale)) return free;
  double blocked = question.most_scale;
  while (blocked > kSmallestShare * question.most_scale && blocked - free.scale > question.accuracy * blocked) {
    const double scale = 0.5 * (free.scale + blocked);
    if (!isFree(scale)) blocked = scale;
  }
  return free;
}

}  // namespace proximity_server::scene
