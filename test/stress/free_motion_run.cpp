#include "stress/free_motion_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "scene/derivative/moved_robot.h"
#include "scene/objects/placed_object.h"
#include "stress/controlled_robots.h"
#include "stress/rounds.h"

namespace proximity_server::scene {
namespace {

using Eigen::VectorXd;

constexpr int kStates = 10;         // of a cell
constexpr int kPairs = 8;           // of a state
constexpr int kMotionsOfPair = 20;  // and 40 of the whole scene
constexpr int kMotionsOfScene = kMotionsOfCell / kStates - kPairs * kMotionsOfPair;
constexpr int kMotionsPerReach = 200;  // the true reach is looked for in one of so many

std::shared_ptr<const SceneModel> robotOf(const ControlFamily& family, Chance& chance) {
  return family.robot ? family.robot : someRobot(chance);
}

class Cell {
 public:
  Cell(const ControlFamily& family, Chance chance, FreeMotionSummary& summary)
      : chance_(chance),
        model_(robotOf(family, chance_)),
        scene_(model_),
        derivatives_(model_),
        free_(model_),
        columns_(model_->robot),
        weights_(columns_.size()),
        gradient_(columns_.size()),
        summary_(summary) {
    if (!family.has_objects) return;
    objects_ = someObjects(model_, chance_);
    scene_.use(objects_);
    derivatives_.use(objects_);
    free_.use(objects_);
    for (const int number : objects_->numbers()) refs_.push_back(ShapeRef::ofObject(number));
  }

  void observe() {
    for (int link = 0; link < static_cast<int>(model_->robot.links.size()); ++link)
      if (model_->robot.hasGeometry(link)) refs_.push_back({link});
    for (int state = 0; state < kStates && failure.empty(); ++state) {
      start_ = somePoses(model_->robot, columns_, chance_);
      if (objects_) frames_ = someFrames(*objects_, chance_);
      place(start_);
      derivatives_.update(start_);
      free_.update(start_);
      for (int i = 0; i < kPairs; ++i) observePair();
      observeScene();
    }
  }

  std::string failure;

 private:
  void place(const BodyPoses& poses) { objects_ ? scene_.update(poses, frames_) : scene_.update(poses); }

  bool isUnbounded(const ShapeRef& ref) const {
    return ref.isObject() && objects_->placed(ref.object())->isUnbounded();
  }

  ShapeRefPair somePair() {
    for (;;) {
      const auto one = [&] { return refs_[static_cast<std::size_t>(chance_.below(static_cast<int>(refs_.size())))]; };
      const ShapeRefPair pair{one(), one()};
      if (pair.a == pair.b || (pair.a.isLink() && pair.a.link() == pair.b.link()) ||
          (isUnbounded(pair.a) && isUnbounded(pair.b)))
        continue;
      return pair;
    }
  }

  /// Towards the border of a bubble, in one of several ways.
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
      for (double& own : motion) own = chance_.between(-1, 1);
    }
    return motion;
  }

  void observePair() {
    const ShapeRefPair pair = somePair();
    place(start_);
    const PairProximity before = scene_.proximity(pair);
    if (!free_.weights(pair, weights_) || !derivatives_.gradient(before, gradient_)) return;
    const double free = std::pow(10.0, chance_.between(-4, 0)), threshold = before.result.lower_bound - free;
    for (int i = 0; i < kMotionsOfPair && failure.empty(); ++i) {
      const int kind = i % 4;
      VectorXd motion = direction(kind);
      const double way = weights_.dot(motion.cwiseAbs());
      if (!(way > 1e-12)) continue;
      motion *= free / way * (1.0 - 1e-14);
      const double part = i % 2 == 0 ? 1.0 : chance_.between(0, 1);
      const double nearest = nearestAfter(part * motion, pair);
      ++summary_.motions;
      summary_.overlaps += before.result.distance < 0.0 ? 1 : 0;
      const double used = (before.result.lower_bound - nearest) / free;
      summary_.most_used = std::max(summary_.most_used, used);
      if (kind == 2 && part == 1.0) {
        summary_.used += used;
        ++summary_.along_gradient;
      }
      if (!(nearest >= threshold))
        failure = "a pair comes below its threshold by " + std::to_string(threshold - nearest) + " m";
      if (summary_.motions % kMotionsPerReach == 0) summary_.reaches.push_back(1.0 / reachOf(motion, pair, threshold));
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
    free_.find(scene_, question);
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
        for (double& own : motion) own = chance_.between(-3, 3);
        motion *= free_.scale(motion);
      }
      if (!free_.contains(motion * (1.0 - 1e-14))) failure = "a scaled motion is not in the bubbles";
      place(moved(model_->robot, columns_, start_, i % 4 < 2 ? motion : VectorXd(chance_.between(0, 1) * motion)));
      ++summary_.motions;
      ++summary_.of_scenes;
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

  Chance chance_;
  const std::shared_ptr<const SceneModel> model_;
  Scene scene_;
  Derivatives derivatives_;
  FreeMotion free_;
  const DegreesOfFreedom columns_;
  std::shared_ptr<const Objects> objects_;
  std::vector<ShapeRef> refs_;
  FramePoses frames_;
  BodyPoses start_;
  VectorXd weights_, gradient_;
  FreeMotionSummary& summary_;
};

}  // namespace

void FreeMotionSummary::merge(const FreeMotionSummary& other) {
  motions += other.motions;
  overlaps += other.overlaps;
  of_scenes += other.of_scenes;
  most_used = std::max(most_used, other.most_used);
  used += other.used;
  along_gradient += other.along_gradient;
  reaches.insert(reaches.end(), other.reaches.begin(), other.reaches.end());
  seconds += other.seconds;
  failed += other.failed;
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
}

std::vector<FreeMotionSummary> runFreeMotions(const FreeMotionRun& run, std::atomic<std::int64_t>& done) {
  const double cells = static_cast<double>(run.motions) / kMotionsOfCell;
  const narrowphase::Rounds rounds(controlFamilies(), run.family, cells);
  return rounds.observe<FreeMotionSummary>(
      run.threads, [&](std::size_t family, std::int64_t number, FreeMotionSummary& summary) {
        const auto start = std::chrono::steady_clock::now();
        const std::int64_t before = summary.motions;
        Cell cell(controlFamilies()[family], chanceOf(run.seed, family, number), summary);
        cell.observe();
        summary.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        done += summary.motions - before;
        if (cell.failure.empty()) return;
        ++summary.failed;
        if (summary.failures.size() < narrowphase::kFailuresKept) summary.failures.push_back({number, cell.failure});
      });
}

}  // namespace proximity_server::scene
