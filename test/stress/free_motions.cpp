// ./dev stress free-motions: moves robots to the border of their bubbles, and measures the distance on the way there.
//
// 1. Of a random pair: take any threshold below its lower bound, and go to the border of its bubble in random
//    directions, along one degree of freedom, along the gradient of the distance, and along the one that brings the two
//    together fastest for its weight.
// 2. Of a whole scene: find the bubbles, and go to their border in random directions.
// 3. At the border, or at a random place on the straight way there, no upper bound of a distance may be below its
//    threshold.
#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "scene/derivative/moved_robot.h"
#include "scene/objects/placed_object.h"
#include "stress/controlled_robots.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::VectorXd;

constexpr int kMotionsOfCell = 2000;
constexpr int kStates = 10;  // of a cell
constexpr int kPairs = 8;    // of a state
constexpr int kMotionsOfPair = 20;
constexpr int kMotionsOfScene = kMotionsOfCell / kStates - kPairs * kMotionsOfPair;
constexpr int kMotionsPerReach = 200;  // the true reach is looked for in one of so many

class Cell : public ControlledCell {
 public:
  Cell(const ControlFamily& family, Chance chance, stress::Tally& tally)
      : ControlledCell(family, chance),
        free_(model_),
        columns_(model_->robot),
        weights_(columns_.size()),
        gradient_(columns_.size()),
        tally_(tally) {
    if (!objects_) return;
    for (const int number : objects_->numbers()) refs_.push_back(ShapeRef::ofObject(number));
  }

  void observe() {
    for (int link = 0; link < static_cast<int>(model_->robot.links.size()); ++link)
      if (model_->robot.hasGeometry(link)) refs_.push_back({link});
    for (int state = 0; state < kStates && failure.empty(); ++state) {
      start_ = somePoses(model_->robot, columns_, chance_);
      moveFrames();
      place(start_);
      for (int i = 0; i < kPairs; ++i) observePair();
      observeScene();
    }
  }

 private:
  bool isUnbounded(const ShapeRef& ref) const {
    return ref.isObject() && objects_->placed(ref.object())->isUnbounded();
  }

  ShapeRefPair somePair() {
    for (;;) {
      const ShapeRef a = chance_.oneOf(refs_), b = chance_.oneOf(refs_);
      const ShapeRefPair pair{a, b};
      if (pair.a == pair.b || (pair.a.isLink() && pair.a.link() == pair.b.link()) ||
          (isUnbounded(pair.a) && isUnbounded(pair.b)))
        continue;
      return pair;
    }
  }

  /// Returns a direction towards the border of a bubble, of one of four kinds.
  VectorXd direction(int kind) {
    VectorXd motion = VectorXd::Zero(columns_.size());
    const auto column = [&] { return chance_.below(columns_.size()); };
    if (kind == 1) {
      const int one = column();
      motion[one] = weights_[one] > 0.0 ? chance_.between(-1, 1) : 0.0;
    } else if (kind == 2) {
      motion = -gradient_;
    } else if (kind == 3) {
      Eigen::Index steepest = 0;
      (gradient_.array().abs() / weights_.array().max(1e-9)).maxCoeff(&steepest);
      motion[steepest] = -gradient_[steepest];
    } else {
      for (Eigen::Index i = 0; i < motion.size(); ++i) motion[i] = chance_.between(-1, 1);
    }
    return motion;
  }

  void observePair() {
    const ShapeRefPair pair = somePair();
    place(start_);
    const PairProximity before = scene_.proximity(pair);
    if (!free_.weights(scene_.state, pair, weights_) || !gradient(scene_.state, before, gradient_)) return;
    const double free = std::pow(10.0, chance_.between(-4, 0)), threshold = before.result.lower_bound - free;
    for (int i = 0; i < kMotionsOfPair && failure.empty(); ++i) {
      const int kind = i % 4;
      VectorXd motion = direction(kind);
      const double way = weights_.dot(motion.cwiseAbs());
      if (!(way > 1e-12)) continue;
      motion *= free / way * (1.0 - 1e-14);
      const double part = i % 2 == 0 ? 1.0 : chance_.between(0, 1);
      const double nearest = nearestAfter(part * motion, pair);
      tally_.add("motions");
      tally_.add("overlaps", before.result.distance < 0.0);
      const double used = (before.result.lower_bound - nearest) / free;
      tally_.raise("most_used", used);
      const bool is_along_gradient = kind == 2 && part == 1.0;
      tally_.add("along_gradient", is_along_gradient);
      tally_.add("used_along_gradient", is_along_gradient ? used : 0.0);
      if (!(nearest >= threshold))
        failure = "a pair comes below its threshold by " + std::to_string(threshold - nearest) + " m";
      if (std::fmod(tally_["motions"], kMotionsPerReach) == 0.0)
        tally_.sample("reach", 1.0 / reachOf(motion, pair, threshold));
    }
  }

  double nearestAfter(const VectorXd& motion, const ShapeRefPair& pair) {
    place(moved(model_->robot, columns_, start_, motion));
    return scene_.proximity(pair).result.upper_bound;
  }

  /// The largest multiple of a motion that is free, by steps of a fiftieth; at most 20.
  double reachOf(const VectorXd& motion, const ShapeRefPair& pair, double threshold) {
    double reach = 1.0;
    for (; reach < 20.0; reach += 0.02 * reach)
      if (nearestAfter(reach * motion, pair) < threshold) break;
    return reach;
  }

  void observeScene() {
    place(start_);
    FreeMotionQuestion question;
    const PairProximity* nearest = scene_.minimum(scene_.candidates());
    if (!nearest) return;
    question.thresholds.links = nearest->result.lower_bound - chance_.between(0, 0.1);
    question.thresholds.objects = nearest->result.lower_bound - chance_.between(0, 0.1);
    question.influence_distance =
        std::max(question.thresholds.links, question.thresholds.objects) + chance_.between(0, 0.3);
    free_.find(scene_.scene, scene_.state, question);
    if (!free_.isKnown()) {
      failure = "the bubbles of a scene are not known";
      return;
    }
    for (int i = 0; i < kMotionsOfScene && failure.empty(); ++i) {
      VectorXd motion = VectorXd::Zero(columns_.size());
      if (i % 2 == 0) {
        const int one = chance_.below(columns_.size());
        const double alone = free_.alone(one);
        motion[one] = (chance_.below(2) == 0 ? 1.0 : -1.0) * std::min(alone, 10.0);
      } else {
        for (Eigen::Index k = 0; k < motion.size(); ++k) motion[k] = chance_.between(-3, 3);
        motion *= free_.scale(motion);
      }
      if (!free_.contains(motion * (1.0 - 1e-14))) failure = "a scaled motion is not in the bubbles";
      place(moved(model_->robot, columns_, start_, i % 4 < 2 ? motion : VectorXd(chance_.between(0, 1) * motion)));
      tally_.add("motions");
      tally_.add("of_scenes");
      considerScene(PairKind::OfLinks, question.thresholds.links);
      if (objects_) considerScene(PairKind::WithObject, question.thresholds.objects);
    }
  }

  void considerScene(PairKind kind, double threshold) {
    Question near;
    near.threshold = threshold;
    for (const PairProximity& pair : scene_.below(Pairs(scene_.candidates(), kind), near))
      if (pair.result.upper_bound < threshold)
        failure = "a pair of a scene comes below its threshold by " +
                  std::to_string(threshold - pair.result.upper_bound) + " m";
  }

  FreeMotion free_;
  const DegreesOfFreedom columns_;
  std::vector<ShapeRef> refs_;
  BodyPoses start_;
  VectorXd weights_, gradient_;
  stress::Tally& tally_;
};

}  // namespace
}  // namespace proximity_server::scene

namespace proximity_server::stress {

Campaign freeMotionCampaign() {
  using namespace scene;
  Campaign campaign{"free_motion_stress", "Looks for free motions that are not free.", "motions", "cell"};
  campaign.option = "--motions";
  campaign.usual = 1000000;
  campaign.cases_of_part = kMotionsOfCell;
  campaign.record_file = "recorded_free_motions.jsonl";
  campaign.families = namesOf(controlFamilies());
  campaign.ask = [](const Part& part, Tally& tally) { askCell<Cell>(controlFamilies()[part.family], part, tally); };
  campaign.columns = {count("motions", 10, "motions"),
                      count("overlaps", 10, "overlaps"),
                      count("of scenes", 10, "of_scenes"),
                      number("most used", 9, "%*.6f", "most_used"),
                      ratio("gradient", 9, "%*.3f", "used_along_gradient", "along_gradient"),
                      {"of reach", 9, "%*.3f", [](const Tally& tally) { return tally.quantile("reach", 0.5); }},
                      ratio("us", 8, "%*.2f", "seconds", "motions", 1e6),
                      failures(8)};
  campaign.legend =
      "most used: the largest part of the free distance by which a pair came nearer; gradient: its mean of motions "
      "along\n"
      "the gradient; of reach: the median of the guaranteed over the true reach of a motion; us: time of a motion.\n"
      "A failure ends its cell.";
  return campaign;
}

}  // namespace proximity_server::stress
