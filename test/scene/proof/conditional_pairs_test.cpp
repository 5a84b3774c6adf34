#include "proximity_server/scene/proof/conditional_pairs.h"

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/files.h"
#include "scene/posed_scene.h"
#include "scene/query/same_pair.h"
#include "scene/small_robots.h"
#include "scene/two_arms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::scene::conditional_pairs_test {

/// A ball at 2 + slide beside a wall whose face is at 2.5: their distance is 0.4 - slide.
const std::string kSled =
    urdfOf(link("wall", box("1 9 9", "3 0 0")) + link("rail") + link("sled", ball("0.1")) +
           joint("lift", "prismatic", "wall", "rail", axis("0 0 1") + limits("-1", "0.25")) +
           joint("slide", "prismatic", "rail", "sled", origin("2 0 0") + axis("1 0 0") + limits("-9", "9")));

/// Said to be 1 m apart with slide below 0.3. That is more than the truth, so that no other bound settles the pair.
std::string sledFile(const RobotModel& robot) {
  return conditionalPairsYaml(
      robot,
      {{{{robot.findLink("wall")}, {robot.findLink("sled")}}, 1.0, {{{findNamed(robot.joints, "slide"), -9.0, 0.3}}}}});
}

std::shared_ptr<const SceneModel> with(const SceneModel& model, const std::string& yaml) {
  SceneModel conditional = model;
  addConditionalPairs(yaml, "pairs.yaml", conditional);
  return std::make_shared<const SceneModel>(std::move(conditional));
}

/// One answer about the sled with a threshold, and the number of pairs that a proof has settled.
struct SledAnswer {
  bool is_near;
  int by_proof;
};

SledAnswer askSled(PosedScene& scene, const BodyPoses& poses, double threshold) {
  scene.update(poses);
  Question question;
  question.threshold = threshold;
  const bool is_near = scene.minimum(scene.candidates(), question) != nullptr;
  const PairCounts& counts = scene.counts();
  EXPECT_EQ(counts.total,
            counts.unknown + counts.by_proof + counts.at_rest + counts.by_motion + counts.by_bounds + counts.computed);
  return {is_near, counts.by_proof};
}

TEST(ConditionalPairs, APairIsSkippedWhereItIsProvenApart) {
  const auto model = modelOf(kSled);
  PosedScene scene(with(*model, sledFile(model->robot)));
  const auto poses = [&](double slide) { return forwardKinematics(model->robot, {{"lift", 0.1}, {"slide", slide}}); };
  EXPECT_EQ(askSled(scene, poses(0.25), 0.9).by_proof, 1);
  EXPECT_EQ(askSled(scene, poses(0.25), 1.0).by_proof, 0) << "the bound does not exceed the threshold";
  EXPECT_EQ(askSled(scene, poses(0.35), 0.04).by_proof, 0) << "outside of the range";
  EXPECT_EQ(askSled(scene, poses(0.35), 0.06).is_near, true);
  EXPECT_EQ(askSled(scene, poses(-9.5), 0.09).by_proof, 0) << "beyond the limits";
}

TEST(ConditionalPairs, PaddingIsSubtractedFromTheBound) {
  const RobotModel robot = robotOf(kSled);
  PairFilterOptions options;
  options.pair_padding = {{{"wall", "sled"}, 0.05}};
  PosedScene scene(with(*modelOf(robot, options), sledFile(robot)));
  const BodyPoses poses = forwardKinematics(robot, {{"slide", 0.25}});
  EXPECT_EQ(askSled(scene, poses, 0.945).by_proof, 1);
  EXPECT_EQ(askSled(scene, poses, 0.955).by_proof, 0);
}

TEST(ConditionalPairs, PosesThatAreNotThoseOfTheModelUseNoProof) {
  const auto model = modelOf(kSled);
  PosedScene scene(with(*model, sledFile(model->robot)));
  BodyPoses poses = forwardKinematics(model->robot, {{"slide", 0.25}});
  const int sled = bodyOf(model->robot, "sled"), rail = bodyOf(model->robot, "rail");
  EXPECT_EQ(askSled(scene, poses, 0.5).by_proof, 1);
  const Eigen::Isometry3d good = *poses[sled];
  poses[sled] = good * turned(1e-8, {0, 0, 1});
  EXPECT_EQ(askSled(scene, poses, 0.5).by_proof, 0) << "a prismatic joint that turns";
  poses[sled] = good * at(0, 1e-8, 0);
  EXPECT_EQ(askSled(scene, poses, 0.5).by_proof, 0) << "a joint that leaves its axis";
  poses[sled] = good;
  poses[rail].reset();
  EXPECT_EQ(askSled(scene, poses, 0.5).by_proof, 0) << "a body without geometry whose pose is missing";
}

TEST(ConditionalPairs, AFollowerMustFollow) {
  const std::string urdf =
      urdfOf(link("wall", box("1 9 9", "3 0 0")) + link("rail") + link("sled", ball("0.1")) +
             joint("first", "prismatic", "wall", "rail", axis("1 0 0") + limits("-1", "0.25")) +
             joint("second", "prismatic", "rail", "sled",
                   origin("2 0 0") + axis("1 0 0") + limits("-9", "9") + "<mimic joint='first' multiplier='0.5'/>"));
  const auto model = modelOf(urdf);
  const std::string yaml =
      conditionalPairsYaml(model->robot, {{pairOf(*model, "wall", "sled"), 1.0, {{{0, -1.0, 0.15}}}}});
  PosedScene scene(with(*model, yaml));
  BodyPoses poses = forwardKinematics(model->robot, {{"first", 0.12}});
  EXPECT_EQ(askSled(scene, poses, 0.5).by_proof, 1);
  const int sled = bodyOf(model->robot, "sled");
  poses[sled] = *poses[sled] * at(0.1, 0, 0);
  EXPECT_EQ(askSled(scene, poses, 0.5).by_proof, 0);
}

/// A beam that turns about z, with limits of several turns.
TEST(ConditionalPairs, PositionsAreThoseNearestToTheMiddleOfTheLimits) {
  const std::string urdf = urdfOf(link("post", ball("0.1", "1 0 0")) + link("beam", box("0.2 0.2 3", "0.5 0 0")) +
                                  joint("turn", "revolute", "post", "beam", axis("0 0 1") + limits("-3", "9")));
  PairFilterOptions options;
  options.only_pairs = {{"post", "beam"}};
  const auto model = modelOf(robotOf(urdf), options);
  const std::string yaml =
      conditionalPairsYaml(model->robot, {{pairOf(*model, "post", "beam"), 5.0, {{{0, 2.0, 4.0}}}}});
  PosedScene scene(with(*model, yaml));
  EXPECT_EQ(askSled(scene, forwardKinematics(model->robot, {{"turn", 3.5}}), 4.0).by_proof, 1);
  EXPECT_EQ(askSled(scene, forwardKinematics(model->robot, {{"turn", 3.5 - 2.0 * M_PI}}), 4.0).by_proof, 1);
  EXPECT_EQ(askSled(scene, forwardKinematics(model->robot, {{"turn", 4.5}}), 4.0).by_proof, 0);
}

TEST(ConditionalPairs, TheTableNamesTheRanges) {
  const auto model = modelOf(kSled);
  const auto conditional = with(*model, sledFile(model->robot));
  const LinkPair& pair = conditional->pairs.pairs.at(0);
  EXPECT_EQ(pair.reason, PairReason::Checked);
  EXPECT_EQ(pair.detail, "proven apart in this range: slide: [-9, 0.3]");
}

void expectRefused(std::string yaml, const std::string& from, const std::string& to, const std::string& message) {
  const std::size_t place = yaml.find(from);
  ASSERT_NE(place, std::string::npos) << from;
  yaml.replace(place, from.size(), to);
  SceneModel model = *modelOf(kSled);
  try {
    addConditionalPairs(yaml, "pairs.yaml", model);
    ADD_FAILURE() << "accepted: " << yaml;
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find("pairs.yaml"), 0U) << error.what();
  }
}

TEST(ConditionalPairs, MalformedFilesAreRefusedWithTheField) {
  const std::string yaml = sledFile(modelOf(kSled)->robot);
  expectRefused(yaml, "links: [wall", "links: [wal",
                "pairs[0]/links: there is no link \"wal\" (did you mean \"wall\"?)");
  expectRefused(yaml, "[wall, sled]", "[wall]", "pairs[0]/links: must name two links");
  expectRefused(yaml, "[wall, sled]", "[wall, rail]", "pairs[0]/links: one of the two has no collision geometry");
  expectRefused(yaml, "distance: 1", "distance: 0", "pairs[0]/distance: must be above 0");
  expectRefused(yaml, "distance: 1", "distance: near", "pairs[0]/distance");
  expectRefused(yaml, "distance: 1", "distance: .nan", "pairs[0]/distance");
  expectRefused(yaml, "distance", "distanc", "distanc");
  expectRefused(yaml, "slide:", "slid:", "slid: there is no movable joint \"slid\"");
  expectRefused(yaml, "[-9, 0.3]", "[0.3, -9]", "slide: is neither a position nor [lower, upper]");
  expectRefused(yaml, "ranges", "range", "range");
  expectRefused(yaml, "pairs:", "pairs: []\nother:", "other");
  expectRefused(yaml, "pairs:\n", "pairs:\n- {links: [sled, wall], distance: 1, ranges: [{slide: 0}]}\n",
                "pairs[1]/links: the pair is there twice");
}

TEST(ConditionalPairs, AnotherModelIsRefused) {
  const std::string yaml = sledFile(modelOf(kSled)->robot);
  const auto hashOf = [](const std::string& text) { return text.substr(0, text.find('\n')); };
  const auto refused = [&](RobotModel robot) {
    const std::string own = hashOf(sledFile(robot));
    SceneModel model = *modelOf(std::move(robot));
    try {
      addConditionalPairs(yaml, "pairs.yaml", model);
      ADD_FAILURE() << "accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("pairs.yaml, line 1: model: the proofs are those of the model"),
                std::string::npos)
          << error.what();
    }
    EXPECT_NE(own, hashOf(yaml));
  };
  RobotModel robot = robotOf(kSled);
  robot.joints[1].upper = 9.1;
  refused(robot);
  robot = robotOf(kSled);
  robot.joints[0].parent_T_joint.translation().x() += 1e-15;
  refused(robot);
  robot = robotOf(kSled);
  robot.pieces[0].shape = robot.pieces[0].shape.padded(0.001);
  refused(robot);
  robot = robotOf(kSled);
  robot.pieces[0].body_T_piece.translate(Eigen::Vector3d(0, 0, 1e-9));
  refused(robot);
  robot = robotOf(kSled);
  robot.links[2].name = "sledge";
  SceneModel model = *modelOf(robot);
  EXPECT_THROW(addConditionalPairs(yaml, "pairs.yaml", model), std::invalid_argument);
  EXPECT_NO_THROW(with(*modelOf(kSled), yaml));
}

TEST(ConditionalPairs, AreReadFromAFile) {
  TemporaryFiles files;
  SceneModel model = *modelOf(kSled);
  readConditionalPairs(files.write("pairs.yaml", sledFile(model.robot)), model);
  EXPECT_EQ(model.pairs.pairs.at(0).proven.ranges.size(), 1U);
  EXPECT_THROW(readConditionalPairs("/no/such/file.yaml", model), std::invalid_argument);
}

// --- no answer changes

/// Boxes about random states in which pairs are proven apart, of pairs that may come near each other.
std::vector<ConditionalPair> randomProofs(const std::shared_ptr<const SceneModel>& model, double distance,
                                          std::mt19937_64& random) {
  std::vector<ConditionalPair> pairs;
  const std::vector<JointRange> ranges = jointRanges(model->robot);
  ProofQuestion question;
  question.contact_distance = distance;
  question.most_boxes = 200;
  for (const int number : model->pairs.checked) {
    const LinkPair& pair = model->pairs.pairs[number];
    const ShapeRefPair links{pair.link_a, pair.link_b};
    ConditionalPair conditional{links, std::numeric_limits<double>::infinity(), {}};
    for (int i = 0; i < (kIsSanitized ? 1 : 8); ++i) {
      const double radius = std::uniform_real_distribution<double>(0.1, 3.0)(random);
      const JointBox box = boxAbout(model->robot, randomPositions(model->robot, ranges, random),
                                    std::vector<double>(model->robot.joints.size(), radius));
      const PairProof proof = proveApart(model, {links}, box, question).front();
      if (proof.outcome != ProofOutcome::Proven || !(proof.lower_bound > 0.0)) continue;
      conditional.distance = std::min(conditional.distance, proof.lower_bound);
      conditional.ranges.push_back(proof.box);
    }
    if (!conditional.ranges.empty()) pairs.push_back(conditional);
  }
  return pairs;
}

bool areSameLists(const std::vector<PairProximity>& some, const std::vector<PairProximity>& others) {
  return std::equal(some.begin(), some.end(), others.begin(), others.end(), areSame);
}

/// Asks both models all kinds of questions in random states, with new scenes, so that warm starts are the same. Returns
/// how many pairs proofs have settled.
long expectSameAnswers(const std::shared_ptr<const SceneModel>& plain, const std::vector<ConditionalPair>& pairs,
                       int states, std::mt19937_64& random) {
  const auto conditional = with(*plain, conditionalPairsYaml(plain->robot, pairs));
  const PosedScene first_plain(plain), first_conditional(conditional);
  const std::vector<JointRange> ranges = jointRanges(plain->robot);
  long by_proof = 0;
  for (int state = 0; state < states; ++state) {
    const BodyPoses poses = forwardKinematics(plain->robot, randomPositions(plain->robot, ranges, random));
    for (const double threshold : {0.0, 0.02, 0.05, 0.3, std::numeric_limits<double>::infinity()}) {
      PosedScene without = first_plain.forAnotherThread(), with_proofs = first_conditional.forAnotherThread();
      without.update(poses);
      with_proofs.update(poses);
      const Candidates& list = without.candidates();
      Question question;
      question.threshold = threshold;
      EXPECT_TRUE(areSameLists(without.closest(list, 3, question), with_proofs.closest(list, 3, question)));
      by_proof += with_proofs.counts().by_proof;
      EXPECT_TRUE(areSameLists(without.below(list, question), with_proofs.below(list, question)));
      const PairsBelow below = without.closestBelow(list, 2, question);
      const PairsBelow also_below = with_proofs.closestBelow(list, 2, question);
      EXPECT_EQ(below.count, also_below.count);
      EXPECT_TRUE(areSameLists(below.closest, also_below.closest));
      const PairProximity *any = without.first(list, question), *also_any = with_proofs.first(list, question);
      EXPECT_EQ(any == nullptr, also_any == nullptr);
      EXPECT_TRUE(!any || !also_any || areSameLists({*any}, {*also_any}));
      by_proof += with_proofs.counts().by_proof;
      if (testing::Test::HasFailure()) return by_proof;
    }
  }
  return by_proof;
}

TEST(ConditionalPairs, NoAnswerOfARandomRobotChanges) {
  std::mt19937_64 random(5);
  long by_proof = 0;
  for (int robot = 0; robot < repeats(20) && !HasFailure(); ++robot) {
    SCOPED_TRACE(robot);
    const auto place = [&] { return std::to_string(std::uniform_real_distribution<double>(0.1, 0.5)(random)); };
    const std::string torso = link("torso", ball("0.15") + box("0.3 0.5 0.1", "0 0 0.4"));
    const auto model =
        modelOf(urdfOf(torso + arm("left_", "0 " + place() + " 0.4") + arm("right_", "0 -" + place() + " " + place())));
    const double distance = robot % 2 == 0 ? 0.0 : 0.05;
    by_proof += expectSameAnswers(model, randomProofs(model, distance, random), repeats(200), random);
  }
  EXPECT_GT(by_proof, kIsSanitized ? -1 : 50);
}

TEST(ConditionalPairs, NoAnswerOfTheDemoRobotChanges) {
  std::mt19937_64 random(6);
  const auto model = demoModel();
  const std::vector<ConditionalPair> pairs = randomProofs(model, 0.02, random);
  EXPECT_GT(pairs.size(), kIsSanitized ? 0U : 30U);
  const long by_proof = expectSameAnswers(model, pairs, repeats(2000), random);
  EXPECT_GT(by_proof, kIsSanitized ? -1 : 0);
}

}  // namespace proximity_server::scene::conditional_pairs_test
