#include "proximity_server/scene/proof/certify.h"

#include "proximity_server/scene/certificate/verify.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "sanitized.h"
#include "scene/derivative/moved_robot.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "scene/proof/random_boxes.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <optional>

namespace proximity_server::scene::certify_test {

/// A certificate with all that it is about.
struct Certified {
  std::shared_ptr<const SceneModel> model;
  std::shared_ptr<const Objects> objects;
  JointBox box;
  PairCertificate certificate;

  std::optional<std::string> flaw() const { return flawIn(certificate, box, *model, objects.get()); }
};

/// [m] The smallest distance of some states, less the padding.
double sampledDistance(const Certified& it, int states, Chance& chance) {
  PosedScene scene(it.model);
  if (it.objects) scene.use(it.objects);
  double closest = std::numeric_limits<double>::infinity();
  for (int s = 0; s < states; ++s)
    closest = std::min(closest, distanceIn(scene, someStateIn(it.model->robot, it.box, chance), it.certificate.pair));
  return closest;
}

/// Some objects that stand, move with a link or are held; a solid among them.
std::shared_ptr<const Objects> someObjects(const std::shared_ptr<const SceneModel>& model, Chance& chance) {
  return std::make_shared<const Objects>(
      Objects(model).changed({AddObject{someObject("crate", Fixed{chance.pose(0.8)}, chance)},
                              AddObject{someSolid("shell", Fixed{chance.pose(0.8)}, chance)},
                              AddObject{someObject("dish", Moving{"fore", chance.pose(0.3)}, chance)},
                              AddObject{someObject("tool", Attached{"hand", {}, chance.pose(0.2)}, chance)}}));
}

/// Proves all pairs of a random robot or of an arm among objects in a random box, and writes certificates.
std::vector<Certified> someCertified(Chance& chance, int& proven) {
  const bool has_objects = chance.below(3) == 0;
  const auto model = has_objects ? arm() : someRobot(chance);
  ProofQuestion question;
  question.most_boxes = 200;
  question.contact_distance = chance.below(2) == 0 ? 0.0 : chance.between(0.0, 0.05);
  if (has_objects) question.objects = someObjects(model, chance);
  const JointBox box = someBox(model->robot, chance);
  const std::vector<ShapeRefPair> pairs =
      has_objects ? checkedPairs(*model, question.objects.get()) : provablePairs(*model);
  const std::vector<PairProof> proofs = proveApart(model, pairs, box, question);
  const auto certificates = certify(model, proofs, question);
  EXPECT_EQ(certificates.size(), proofs.size());
  std::vector<Certified> certified;
  for (std::size_t i = 0; i < proofs.size(); ++i) {
    proven += proofs[i].outcome == ProofOutcome::Proven;
    if (!certificates[i]) continue;
    EXPECT_EQ(proofs[i].outcome, ProofOutcome::Proven);
    EXPECT_GT(certificates[i]->bound, question.contact_distance);
    certified.push_back({model, question.objects, box, *certificates[i]});
  }
  return certified;
}

TEST(Certify, EveryProofHasACertificateThatVerifiesAndIsTrue) {
  Chance chance(45);
  int proven = 0, certified = 0, with_objects = 0, divided = 0, several_axes = 0, near_bound = 0;
  for (int i = 0; i < repeats(150); ++i) {
    for (const Certified& it : someCertified(chance, proven)) {
      ++certified;
      with_objects += it.objects != nullptr;
      divided += it.certificate.tree.size() > 1;
      several_axes += it.certificate.tree.back().axes.size() > 1;
      EXPECT_EQ(it.flaw(), std::nullopt);
      const double closest = sampledDistance(it, 40, chance);
      ASSERT_GE(closest, it.certificate.bound - 1e-12) << i;
      near_bound += closest < it.certificate.bound + 0.02;
    }
  }
  EXPECT_EQ(certified, proven);
  if (kIsSanitized) return;
  EXPECT_GT(with_objects, 200);
  EXPECT_GT(divided, 50);
  EXPECT_GT(several_axes, 50);
  EXPECT_GT(near_bound, 100);
}

/// Certificates of all pairs that are proven within the limits of a robot, each verified. Returns their number.
int countCertified(const std::shared_ptr<const SceneModel>& model, const std::vector<ShapeRefPair>& pairs) {
  const JointBox box = knownRanges(model->robot);
  ProofQuestion question;
  question.contact_distance = 1e-6;
  question.most_boxes = 2000;
  const std::vector<PairProof> proofs = proveApart(model, pairs, box, question);
  const auto certificates = certify(model, proofs, question);
  int certified = 0;
  for (std::size_t i = 0; i < proofs.size(); ++i) {
    EXPECT_EQ(certificates[i].has_value(), proofs[i].outcome == ProofOutcome::Proven)
        << nameOf(pairs[i].a, model->robot) << " - " << nameOf(pairs[i].b, model->robot);
    if (!certificates[i]) continue;
    ++certified;
    EXPECT_EQ(flawIn(*certificates[i], box, *model), std::nullopt);
  }
  return certified;
}

TEST(Certify, PairsOfTheDemoRobotHaveCertificates) {
  const auto model = demoModel();
  EXPECT_GE(countCertified(model, Candidates(model->pairs).list()), 18);
}

TEST(Certify, PairsThatPandasSrdfDisablesHaveCertificates) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  const auto model = modelOf(kExampleRobots[0], resolve, quickLoading());
  std::vector<ShapeRefPair> disabled;
  for (const LinkPair& pair : model->pairs.pairs)
    if (pair.reason == PairReason::SrdfDisabled) disabled.push_back({pair.link_a, pair.link_b});
  EXPECT_GE(countCertified(model, disabled), 16);
}

// --- a certificate that was changed

/// A node of the tree, or nullptr if it is no leaf with axes.
CertificateNode* someLeaf(Certified& it, Chance& chance) {
  auto& tree = it.certificate.tree;
  CertificateNode& node = tree[static_cast<std::size_t>(chance.below(static_cast<int>(tree.size())))];
  return node.axes.empty() ? nullptr : &node;
}

/// Changes the evidence in a way in which it cannot be evidence any more. Returns false if that is not possible.
bool spoilEvidence(Certified& it, Chance& chance) {
  auto& tree = it.certificate.tree;
  const auto at = chance.below(static_cast<int>(tree.size()));
  switch (chance.below(6)) {
    case 0:
      tree.erase(tree.begin() + at);
      return true;
    case 1:
      tree.insert(tree.begin() + at, CertificateNode());
      return true;
    case 2:
      std::swap(it.certificate.pair.a, it.certificate.pair.b);
      return someLeaf(it, chance) != nullptr && tree.size() == 1 && tree[0].axes.size() == 1;
    case 3:
      if (CertificateNode* leaf = someLeaf(it, chance); leaf && leaf->axes.size() == 1) {
        leaf->axes[0].direction *= -1.0;
        return true;
      }
      return false;
    case 4:
      if (CertificateNode* leaf = someLeaf(it, chance)) {
        leaf->axes.clear();
        return true;
      }
      return false;
    default:
      if (tree[static_cast<std::size_t>(at)].joint < 0) return false;
      tree[static_cast<std::size_t>(at)].at += chance.eitherSign(100.0);
      return true;
  }
}

/// Changes the statement, so that it may be wrong.
void changeStatement(Certified& it, Chance& chance) {
  const auto interval = static_cast<std::size_t>(chance.below(static_cast<int>(it.box.size())));
  switch (chance.below(4)) {
    case 0:
      it.certificate.bound += chance.decades(-6.0, 0.0);
      return;
    case 1:
      it.box[interval].lower -= chance.decades(-3.0, 0.5);
      return;
    case 2:
      it.box[interval].upper += chance.decades(-3.0, 0.5);
      return;
    default: {
      SceneModel changed = *it.model;
      Joint& joint =
          changed.robot.joints[static_cast<std::size_t>(chance.below(static_cast<int>(changed.robot.joints.size())))];
      joint.parent_T_joint =
          joint.parent_T_joint * Eigen::Translation3d(chance.decades(-3.0, 0.0) * chance.direction());
      it.model = std::make_shared<const SceneModel>(std::move(changed));
    }
  }
}

/// Changes the evidence by a little, so that it may be weaker.
void weakenEvidence(Certified& it, Chance& chance) {
  auto& tree = it.certificate.tree;
  CertificateNode& node = tree[static_cast<std::size_t>(chance.below(static_cast<int>(tree.size())))];
  if (node.joint >= 0) {
    node.at += chance.eitherSign(chance.decades(-3.0, 0.0));
  } else if (!node.axes.empty()) {
    SeparatingAxis& axis = node.axes[static_cast<std::size_t>(chance.below(static_cast<int>(node.axes.size())))];
    if (chance.below(3) == 0)
      axis.link = chance.below(static_cast<int>(it.model->robot.links.size()));
    else
      axis.direction += chance.decades(-3.0, 0.5) * chance.direction();
  }
}

TEST(Certify, SpoiledEvidenceIsRefused) {
  Chance chance(46);
  int refused = 0, proven = 0;
  for (int i = 0; i < repeats(150); ++i) {
    for (const Certified& it : someCertified(chance, proven)) {
      for (int k = 0; k < 4; ++k) {
        Certified spoiled = it;
        if (!spoilEvidence(spoiled, chance)) continue;
        ASSERT_NE(spoiled.flaw(), std::nullopt) << i;
        ++refused;
      }
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(refused, 1000);
  }
}

/// Checks that no random state contradicts a certificate that was accepted.
TEST(Certify, NoChangedStatementThatAStateContradictsIsAccepted) {
  Chance chance(47);
  int refused = 0, accepted = 0, contradicted = 0, proven = 0;
  for (int i = 0; i < repeats(150); ++i) {
    for (const Certified& it : someCertified(chance, proven)) {
      if (it.objects) continue;  // they are those of the model before the change
      for (int k = 0; k < 4; ++k) {
        Certified changed = it;
        changeStatement(changed, chance);
        if (chance.below(2) == 0) weakenEvidence(changed, chance);
        const bool is_accepted = !changed.flaw();
        const bool is_wrong = sampledDistance(changed, 30, chance) < changed.certificate.bound - 1e-12;
        ASSERT_FALSE(is_accepted && is_wrong) << i;
        ++(is_accepted ? accepted : refused);
        contradicted += is_wrong;
      }
    }
  }
  if (kIsSanitized) return;
  EXPECT_GT(refused, 1000);
  EXPECT_GT(contradicted, 300);
  EXPECT_GT(accepted, 100);
}

TEST(Certify, WhatTheBudgetLeavesHasNoCertificate) {
  // The corners of the post are 5 cm from the ball where it passes them.
  const auto model = modelOf(urdfOf(link("post", box("1.2 1.2 0.2")) + link("arm", ball("0.1", "1 0 0")) +
                                    joint("turn", "revolute", "post", "arm", axis("0 0 1") + limits("-3", "3"))));
  const std::vector<PairProof> proofs = proveApart(model, {pairOf(*model, "post", "arm")}, jointRanges(model->robot));
  ASSERT_EQ(proofs[0].outcome, ProofOutcome::Proven);
  const auto certificates = certify(model, proofs);
  ASSERT_TRUE(certificates[0]);
  EXPECT_GT(certificates[0]->tree.size(), 1U);
  ProofQuestion question;
  question.most_boxes = 1;
  EXPECT_FALSE(certify(model, proofs, question)[0]);
  question = {};
  const std::atomic<bool> stop{true};
  question.deadline = Deadline(stop);
  EXPECT_FALSE(certify(model, proofs, question)[0]);
}

TEST(Certify, TheResultIsTheSameForAnyNumberOfThreads) {
  Chance chance(42);
  const auto model = someRobot(chance);
  const std::vector<PairProof> proofs = proveApart(model, provablePairs(*model), someBox(model->robot, chance));
  ProofQuestion question;
  const auto one = certify(model, proofs, question);
  double last = 0.0;
  question.progress = [&](double share) { last = share; };
  question.threads = 3;
  const auto three = certify(model, proofs, question);
  EXPECT_EQ(last, 1.0);
  int compared = 0;
  for (std::size_t i = 0; i < proofs.size(); ++i) {
    ASSERT_EQ(one[i].has_value(), three[i].has_value());
    if (!one[i]) continue;
    ++compared;
    EXPECT_EQ(one[i]->bound, three[i]->bound);
    EXPECT_EQ(one[i]->tree.size(), three[i]->tree.size());
  }
  EXPECT_GT(compared, 3);
}

}  // namespace proximity_server::scene::certify_test
