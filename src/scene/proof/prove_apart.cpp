#include "proximity_server/scene/proof/prove_apart.h"

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/proof/box_search.h"
#include "scene/proof/pair_certificate.h"
#include "scene/scene_model/given_model.h"
#include "system/pipeline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

void requireValid(const SceneModel& model, const ProofQuestion& question) {
  if (model.robot.robots.size() > 1)
    throw std::invalid_argument("the model has several robots, and their places are not known");
  if (question.objects && &question.objects->model() != &model)
    throw std::invalid_argument("the objects are those of another model");
  if (!(question.contact_distance >= 0.0) || !std::isfinite(question.contact_distance))
    throw std::invalid_argument("the contact distance is " + shortest(question.contact_distance) +
                                ", but must be finite and not negative");
  if (!(question.tightness >= 0.0 && question.tightness < 1.0))
    throw std::invalid_argument("the tightness is " + shortest(question.tightness) + ", but must be in [0, 1)");
  if (question.most_boxes < 1 || question.threads < 1)
    throw std::invalid_argument("a proof needs at least one box and one thread");
}

/// The proofs of several pairs, in rounds.
class Proofs {
 public:
  Proofs(const std::shared_ptr<const SceneModel>& model, const std::vector<ShapeRefPair>& pairs, const JointBox& box,
         const ProofQuestion& question)
      : model_(model),
        question_(question),
        scene_(model),
        measures_(static_cast<std::size_t>(question.threads)),
        settled_(pairs.size(), 0.0) {
    for (const ShapeRefPair& pair : pairs) searches_.emplace_back(*model, pair, box, question);
  }

  std::vector<PairProof> run() {
    constexpr long kFirst = 128, kGrowth = 4;
    for (long boxes = std::min(kFirst, question_.most_boxes);;
         boxes = std::min(kGrowth * boxes, question_.most_boxes)) {
      runRound(boxes);
      if (boxes == question_.most_boxes || question_.deadline.hasPassed()) break;
    }
    std::vector<PairProof> proofs;
    for (const BoxSearch& search : searches_) proofs.push_back(search.result());
    return proofs;
  }

 private:
  void runRound(long boxes) {
    std::size_t next = 0;
    const auto read = [&](std::size_t& search) {
      while (next < searches_.size() && searches_[next].isSettled()) ++next;
      search = next++;
      return search < searches_.size();
    };
    const auto work = [&](std::size_t& search, int thread) {
      if (question_.deadline.hasPassed()) return;
      std::unique_ptr<BoxMeasures>& measures = measures_[static_cast<std::size_t>(thread)];
      if (!measures) measures = std::make_unique<BoxMeasures>(model_, question_.objects);
      measures->begin(scene_);
      searches_[search].run(*measures, boxes);
      certify(searches_[search], boxes);
    };
    const auto tell = [&](std::size_t& search) {
      const PairProof proof = searches_[search].result();
      settled_[search] = searches_[search].isSettled() ? 1.0 : 1.0 - proof.undecided;
      if (!question_.progress) return;
      double sum = 0.0;
      for (const double settled : settled_) sum += settled;
      question_.progress(sum / static_cast<double>(settled_.size()));
    };
    system::runPipeline<std::size_t>({read, work, tell}, {question_.threads});
  }

  /// Looks for a certificate where the search has not decided, if a decision is all that is asked for.
  void certify(BoxSearch& search, long boxes) const {
    const bool wants_decision = question_.goal == ProofQuestion::Goal::Decision && question_.tightness == 0.0;
    if (search.isSettled() || !wants_decision) return;
    // A node bounds each pair of pieces along each axis: of long chains it takes as long as hundreds of boxes.
    constexpr long kBoxesOfNode = 256;
    if (const auto certificate = certificateOf(search.result(), *model_, question_, boxes / kBoxesOfNode))
      search.settle(certificate->bound);
  }

  const std::shared_ptr<const SceneModel> model_;
  const ProofQuestion& question_;
  Scene scene_;  ///< each pair begins with another scene made from it
  std::vector<BoxSearch> searches_;
  std::vector<std::unique_ptr<BoxMeasures>> measures_;  ///< by thread
  std::vector<double> settled_;                         ///< by pair
};

}  // namespace

std::vector<PairProof> proveApart(const std::shared_ptr<const SceneModel>& model,
                                  const std::vector<ShapeRefPair>& pairs, const JointBox& box,
                                  const ProofQuestion& question) {
  requireValid(given(model), question);
  return Proofs(model, pairs, box, question).run();
}

}  // namespace proximity_server::scene
