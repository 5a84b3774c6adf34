// Skipping changes no answer where objects come, go, move, jump and are attached.
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"
#include "sanitized.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

namespace proximity_server::scene::object_skipping_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kAgreement = 1e-12;  // [m]
constexpr double kTolerance = 1e-12;  // [m] asked of every distance
constexpr std::size_t kClosest = 5;

enum class Motion : unsigned char { Random, Coherent, Resting };
enum class Meshes : unsigned char { None, Solid };

/// Objects that change, and a robot and frames that move.
class Cell {
 public:
  Cell(const std::shared_ptr<const SceneModel>& model, Motion motion, int objects, Meshes meshes)
      : model_(*model),
        motion_(motion),
        meshes_(meshes),
        wanted_(objects),
        chance_(static_cast<unsigned>(motion) + 7),
        objects_(std::make_shared<const Objects>(model)),
        phases_(model->robot.joints.size()) {
    jump();
    for (int i = 0; i < wanted_; ++i) change();
  }

  const std::shared_ptr<const Objects>& objects() const { return objects_; }
  const BodyPoses& poses() const { return poses_; }
  const FramePoses& frames() const { return frame_poses_; }

  /// Returns whether the objects have changed.
  bool next() {
    const bool changes = chance_.below(motion_ == Motion::Random ? 2 : 12) == 0;
    if (changes) change();
    if (motion_ == Motion::Random || chance_.below(80) == 0)
      jump();
    else if (motion_ == Motion::Coherent || chance_.below(8) == 0)
      step();
    place();
    return changes;
  }

 private:
  void jump() {
    for (double& phase : phases_) phase = chance_.between(-10, 10);
    base_ =
        Eigen::Translation3d(0.1 * chance_.direction()) * Eigen::AngleAxisd(chance_.between(-3, 3), Vector3d::UnitZ());
    for (Isometry3d& frame : known_frames_) frame = chance_.pose(0.7);
    missing_ = chance_.below(6) - 3;
  }

  void step() {
    for (std::size_t joint = 0; joint < phases_.size(); ++joint)
      phases_[joint] += 0.0005 * static_cast<double>(joint + 1);
    for (Isometry3d& frame : known_frames_)
      frame = frame * Eigen::Translation3d(0.0003, 0.0002, 0) * Eigen::AngleAxisd(0.001, Vector3d::UnitX());
  }

  void place() {
    std::vector<double> positions;
    for (const double phase : phases_) positions.push_back(2.5 * std::sin(phase));
    poses_ = forwardKinematics(model_.robot, positions);
    for (auto& pose : poses_) pose = base_ * *pose;
    frame_poses_.clear();
    for (const std::string& name : objects_->frames()) {
      const int frame = name.back() - '0';
      frame_poses_.push_back(frame == missing_ ? std::nullopt : std::optional(known_frames_[frame]));
    }
  }

  Placement freePlacement() {
    if (chance_.below(3) == 0) return Moving{"frame " + std::to_string(chance_.below(3)), chance_.pose(0.2)};
    return Fixed{chance_.pose(1.0)};
  }

  Attached attachment() {
    const char* const links[] = {"hand", "fore", "camera", "base", "wrist"};
    Attached attached{links[chance_.below(5)]};
    attached.link_T_object = chance_.below(4) == 0 ? Isometry3d::Identity() : chance_.pose(0.15);
    for (int i = chance_.below(3); i-- > 0;) attached.touch_links.emplace_back(links[chance_.below(5)]);
    return attached;
  }

  Placement anyPlacement() {
    if (chance_.below(5) == 0) return attachment();
    return freePlacement();
  }

  Object newObject(const std::string& id, const Placement& placement) {
    const bool is_solid = meshes_ == Meshes::Solid && chance_.below(3) == 0;
    return is_solid ? someSolid(id, placement, chance_) : someObject(id, placement, chance_);
  }

  std::string someId() { return objects_->object(objects_->numbers()[chance_.below(objects_->size())])->id; }

  void change() {
    if (chance_.below(20) == 0) {
      ObjectRules rules;
      if (chance_.below(2)) rules.free_objects = ObjectRules::FreeObjects::Checked;
      if (chance_.below(2)) rules.base = ObjectRules::Base::StandsStill;
      if (chance_.below(2) && !objects_->empty()) rules.allowed.set(someId(), "*", AllowedPairs::Rule::Allowed);
      objects_ = std::make_shared<const Objects>(objects_->withRules(rules));
    }
    objects_ = std::make_shared<const Objects>(objects_->changed({someChange()}));
  }

  ObjectChange someChange() {
    const bool too_few = chance_.below(2 * wanted_) >= objects_->size();
    if (objects_->empty() || too_few) return AddObject{newObject("object " + std::to_string(added_++), anyPlacement())};
    const std::string id = someId();
    const Object& object = *objects_->object(objects_->find(id));
    const bool can_be_attached = shapesOf(object).front().description != "half-space";
    switch (chance_.below(4)) {
      case 0:
        return RemoveObject{id};
      case 1:
        return ReplaceObject{newObject(id, anyPlacement())};
      case 2:
        if (can_be_attached) return ReplaceObject{{id, object.geometry, attachment()}};
        [[fallthrough]];
      default:
        return ReplaceObject{{id, object.geometry, freePlacement()}};
    }
  }

  const SceneModel& model_;
  const Motion motion_;
  const Meshes meshes_;
  const int wanted_;
  Chance chance_;
  std::shared_ptr<const Objects> objects_;
  std::vector<double> phases_;
  Isometry3d base_ = Isometry3d::Identity();
  std::array<Isometry3d, 3> known_frames_{};
  int missing_ = -1;  // number of the frame without a pose
  int added_ = 0;
  BodyPoses poses_;
  FramePoses frame_poses_;
};

using Names = std::tuple<int, int, int, int>;
Names namesOf(const ShapeRefPair& pair) { return {pair.a.link(), pair.a.object(), pair.b.link(), pair.b.object()}; }

/// The distances of all pairs whose poses are known, without skipping, less their thresholds.
class Truth {
 public:
  explicit Truth(const std::vector<PairProximity>& all, const PairDistances& thresholds = {})
      : thresholds_(thresholds) {
    for (const PairProximity& pair : all) {
      if (pair.result.status == Status::Unknown) continue;
      const double excess = excessOf(pair);
      distances_[namesOf(pair.asked)] = excess;
      sorted_.push_back(excess);
    }
    std::sort(sorted_.begin(), sorted_.end());
  }

  std::size_t size() const { return sorted_.size(); }
  double smallest(std::size_t i) const { return sorted_.at(i); }
  double of(const ShapeRefPair& asked) const { return distances_.at(namesOf(asked)); }
  double excessOf(const PairProximity& pair) const { return pair.result.distance - thresholds_.of(pair.asked); }
  std::size_t countBelow(double threshold) const {
    return static_cast<std::size_t>(std::upper_bound(sorted_.begin(), sorted_.end(), threshold) - sorted_.begin());
  }

 private:
  const PairDistances thresholds_;
  std::map<Names, double> distances_;
  std::vector<double> sorted_;
};

void expectClosest(const std::vector<PairProximity>& found, const Truth& truth) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_NEAR(truth.excessOf(found[i]), truth.smallest(i), kAgreement);
    ASSERT_NEAR(truth.excessOf(found[i]), truth.of(found[i].asked), kAgreement);
  }
}

/// Half of the pairs, and half of the links with objects, have one of their own.
PairDistances randomThresholds(const RobotModel& robot, Chance& chance) {
  PairDistances thresholds(chance.between(0.0, 0.1), chance.between(0.0, 0.3));
  for (int a = 0; a < static_cast<int>(robot.links.size()); ++a) {
    if (chance.below(2) == 0) thresholds.setWithObjects(a, chance.between(0.0, 0.5));
    for (int b = a + 1; b < static_cast<int>(robot.links.size()); ++b)
      if (chance.below(2) == 0) thresholds.setPair(b, a, chance.between(0.0, 0.5));
  }
  return thresholds;
}

/// All questions with thresholds of single pairs.
void expectSameWithThresholds(Scene& scene, const Pairs& pairs, const std::vector<PairProximity>& all,
                              const PairDistances& thresholds) {
  const Truth truth(all, thresholds);
  Question question;
  question.tolerance = kTolerance;
  question.thresholds = &thresholds;
  expectClosest({*scene.minimum(pairs, question)}, truth);
  expectClosest(scene.closest(pairs, kClosest, question), truth);
  question.threshold = 0.02;
  const std::vector<PairProximity> found = scene.below(pairs, question);
  ASSERT_GE(found.size(), truth.countBelow(question.threshold - kAgreement));
  ASSERT_LE(found.size(), truth.countBelow(question.threshold + kAgreement));
  expectClosest(found, truth);
  const PairsBelow some = scene.closestBelow(pairs, 2, question);
  ASSERT_EQ(some.count, static_cast<int>(found.size()));
  expectClosest(some.closest, truth);
  ASSERT_EQ(scene.first(pairs, question) != nullptr, !found.empty());
}

struct Case {
  const char* name;
  Motion motion;
  int objects, states;
  Meshes meshes = Meshes::None;
};

class ChangingObjects : public testing::TestWithParam<Case> {};

TEST_P(ChangingObjects, SkippingNeverChangesAnAnswer) {
  const auto model = arm();
  Cell cell(model, GetParam().motion, GetParam().objects, GetParam().meshes);
  Scene scene(model), everything(model, Skipping::Off);
  scene.use(cell.objects());
  everything.use(cell.objects());
  const Candidates& candidates = scene.candidates();
  Question question, near;
  question.tolerance = near.tolerance = kTolerance;
  near.threshold = 0.05;
  Chance chance(11);
  const PairDistances thresholds = randomThresholds(model->robot, chance);
  long overlaps = 0, unknown = 0, changes = 0, with_object = 0, attached = 0;
  PairCounts sum;
  for (int state = 0; state < GetParam().states && !HasFatalFailure(); ++state) {
    SCOPED_TRACE("state " + std::to_string(state));
    if (cell.next()) {
      ++changes;
      scene.use(cell.objects());
      everything.use(cell.objects());
    }
    scene.update(cell.poses(), cell.frames());
    everything.update(cell.poses(), cell.frames());
    for (const PairKind kind : {PairKind::Any, PairKind::OfLinks, PairKind::WithObject}) {
      const Pairs pairs(candidates, kind);
      const std::vector<PairProximity> distances = everything.all(pairs, question);
      const Truth truth(distances);
      const PairCounts all = everything.counts();
      ASSERT_EQ(all.computed + all.unknown, all.total);
      if (truth.size() == 0) continue;

      const PairProximity minimum = *scene.minimum(pairs, question);
      expectClosest({minimum}, truth);
      const PairCounts counts = scene.counts();
      ASSERT_EQ(counts.total, all.total);
      ASSERT_EQ(counts.unknown, all.unknown);
      ASSERT_EQ(counts.total, counts.unknown + counts.at_rest + counts.by_motion + counts.by_bounds + counts.computed);
      sum.computed += counts.computed;
      sum.at_rest += counts.at_rest;
      sum.by_motion += counts.by_motion;
      sum.total += counts.total;

      expectClosest(scene.closest(pairs, kClosest, question), truth);
      const std::vector<PairProximity> found = scene.below(pairs, near);
      ASSERT_GE(found.size(), truth.countBelow(near.threshold - kAgreement));
      ASSERT_LE(found.size(), truth.countBelow(near.threshold + kAgreement));
      expectClosest(found, truth);
      const PairsBelow some = scene.closestBelow(pairs, 2, near);
      ASSERT_EQ(some.count, static_cast<int>(found.size()));
      expectClosest(some.closest, truth);
      const PairProximity* first = scene.first(pairs, near);
      ASSERT_EQ(first != nullptr, !found.empty());
      expectSameWithThresholds(scene, pairs, distances, thresholds);

      if (kind != PairKind::Any) continue;
      overlaps += truth.smallest(0) < 0.0;
      unknown += counts.unknown;
      with_object += minimum.asked.b.object() >= 0;
      attached += minimum.asked.a.object() >= 0;
    }
  }
  if (kIsSanitized) return;  // what follows is of the whole test
  EXPECT_GT(changes, GetParam().states / 20);
  EXPECT_GT(unknown, 0);
  EXPECT_GT(overlaps, GetParam().states / 50);
  EXPECT_GT(with_object, GetParam().states / 50);
  EXPECT_GT(attached, 0);
  EXPECT_LT(sum.computed, sum.total / 2);
  if (GetParam().motion != Motion::Random) {
    EXPECT_GT(sum.at_rest + sum.by_motion, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, ChangingObjects,
                         testing::Values(Case{"Random", Motion::Random, 12, repeats(400)},
                                         Case{"Coherent", Motion::Coherent, 12, repeats(400)},
                                         Case{"Resting", Motion::Resting, 12, repeats(400)},
                                         Case{"ManyCoherent", Motion::Coherent, 120, repeats(100)},
                                         Case{"ManyRandom", Motion::Random, 120, repeats(100)},
                                         Case{"SolidsRandom", Motion::Random, 6, repeats(200), Meshes::Solid},
                                         Case{"SolidsCoherent", Motion::Coherent, 6, repeats(200), Meshes::Solid},
                                         Case{"SolidsResting", Motion::Resting, 6, repeats(1000), Meshes::Solid}),
                         [](const testing::TestParamInfo<Case>& test) { return test.param.name; });

}  // namespace proximity_server::scene::object_skipping_test
