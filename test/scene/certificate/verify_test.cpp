#include "proximity_server/scene/certificate/verify.h"

#include "proximity_server/scene/proof/joint_box.h"
#include "scene/small_robots.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::scene::certificate_test {

using Eigen::Vector3d;

/// A box from -0.5 to 0.5, and one from 1.5 to 2.5 that a joint moves along x: they are 1 + slide apart. The third link
/// turns on the second one, and its joint does not matter to the two.
const std::string kSlider =
    urdfOf(link("base", box("1 1 1")) + link("sled", box("1 1 1")) + link("flag", ball("0.1", "0 0 1")) +
           joint("slide", "prismatic", "base", "sled", origin("2 0 0") + axis("1 0 0") + limits("-1", "2")) +
           joint("turn", "revolute", "sled", "flag", axis("0 0 1") + limits("-1", "1")));

class Certificates : public ::testing::Test {
 protected:
  CertificateNode leaf(const char* link, const Vector3d& axis) const {
    return {-1, 0.0, {{model_->robot.findLink(link), axis}}};
  }
  CertificateNode division(int joint, double at) const { return {joint, at, {}}; }

  std::string flaw(double bound, const std::vector<CertificateNode>& tree,
                   const JointBox& box = {{0, 0.5, 1.0}}) const {
    return flawIn({pairOf(*model_, "base", "sled"), bound, tree}, box, *model_).value_or("");
  }
  void expectFlaw(const std::string& reason, double bound, const std::vector<CertificateNode>& tree,
                  const JointBox& box = {{0, 0.5, 1.0}}) const {
    const std::string found = flaw(bound, tree, box);
    EXPECT_NE(found.find(reason), std::string::npos) << reason << ": " << found;
  }

  const std::shared_ptr<const SceneModel> model_ = modelOf(kSlider);
  const CertificateNode leaf_ = leaf("base", Vector3d::UnitX());
};

TEST_F(Certificates, AnAxisProvesTheDistanceAlongIt) {
  EXPECT_EQ(flaw(1.5 - 1e-12, {leaf_}), "");
  EXPECT_EQ(flaw(1.5 - 1e-12, {leaf("sled", {7.0, 0.0, 0.0})}), "") << "the length of an axis does not matter";
  expectFlaw("node 1, where slide=0.5..1: its axes prove 1.4999", 1.5 + 1e-12, {leaf_});
  expectFlaw("its axes prove -", 0.1, {leaf("base", -Vector3d::UnitX())});
  expectFlaw("its axes prove", 1.49, {leaf("base", {1.0, 0.2, 0.0})});
  expectFlaw("its axes prove -inf m", 0.1, {{-1, 0.0, {}}});
}

TEST_F(Certificates, OneOfSeveralAxesIsEnough) {
  CertificateNode both = leaf("base", Vector3d::UnitY());
  both.axes.push_back(leaf_.axes[0]);
  EXPECT_EQ(flaw(1.4, {both}), "");
}

TEST_F(Certificates, TheTreeCoversTheBoxExactly) {
  EXPECT_EQ(flaw(1.4, {division(0, 0.6), leaf_, leaf_}), "");
  EXPECT_EQ(flaw(1.4, {division(0, 0.6), leaf_, division(0, 0.8), leaf_, leaf_}), "");
  expectFlaw("its tree ends before the part where slide=0.5..1", 1.4, {});
  expectFlaw("its tree ends before the part where slide=0.6..1", 1.4, {division(0, 0.6), leaf_});
  expectFlaw("its tree is complete before node 2", 1.4, {leaf_, leaf_});
  expectFlaw("node 1, where slide=0.5..1: it divides slide at 1.2", 1.4, {division(0, 1.2), leaf_, leaf_});
  expectFlaw("it divides slide at 0.5", 1.4, {division(0, 0.5), leaf_, leaf_});
  expectFlaw("node 2, where slide=0.5..0.6: it divides slide at 0.8", 1.4,
             {division(0, 0.6), division(0, 0.8), leaf_, leaf_, leaf_});
  expectFlaw("it divides turn at 0", 1.4, {division(1, 0.0), leaf_, leaf_}, {{0, 0.5, 1.0}, {1, -1.0, 1.0}});
  expectFlaw("it divides slide at nan", 1.4, {division(0, NAN), leaf_, leaf_});
}

TEST_F(Certificates, WhatCannotBeEvidenceIsRefused) {
  expectFlaw("an axis is fixed to flag, which is not between the two", 1.4, {leaf("flag", Vector3d::UnitX())},
             {{0, 0.5, 1.0}, {1, 0.0, 0.0}});
  for (const Vector3d& axis : {Vector3d(0, 0, 0), Vector3d(NAN, 0, 0), Vector3d(INFINITY, 0, 0), Vector3d(1e200, 0, 0),
                               Vector3d(1e-160, 0, 0)})
    expectFlaw("an axis has no direction", 1.4, {leaf("base", axis)});
  expectFlaw("its bound is not finite", NAN, {leaf_});
  expectFlaw("its bound is not finite", -INFINITY, {leaf_});
  expectFlaw("joint \"slide\" has no interval", 1.4, {leaf_}, {});
  expectFlaw("joint \"slide\" has no finite interval", 1.4, {leaf_}, {{0, 1.0, 0.5}});
  expectFlaw("joint \"slide\" has no finite interval", 1.4, {leaf_}, {{0, 0.5, INFINITY}});
  expectFlaw("joint \"slide\" has no finite interval", 1.4, {leaf_}, {{0, NAN, 1.0}});
}

TEST_F(Certificates, ThePaddingOfThePairIsSubtracted) {
  PairFilterOptions options;
  options.pair_padding = {{{"base", "sled"}, 0.25}};
  const auto padded = modelOf(kSlider, options);
  const PairCertificate certificate{pairOf(*padded, "base", "sled"), 1.25 - 1e-9, {leaf_}};
  EXPECT_EQ(flawIn(certificate, {{0, 0.5, 1.0}}, *padded), std::nullopt);
  EXPECT_NE(flawIn({certificate.pair, 1.25 + 1e-9, {leaf_}}, {{0, 0.5, 1.0}}, *padded), std::nullopt);
}

TEST_F(Certificates, UnknownShapesAreRefused) {
  const auto refuses = [&](const ShapeRefPair& pair) {
    EXPECT_THROW(flawIn({pair, 1.0, {leaf_}}, {{0, 0.5, 1.0}}, *model_), std::invalid_argument);
  };
  refuses({{7}, {0}});
  refuses({ShapeRef(0, 1), {1}});
  refuses({ShapeRef::ofObject(0), {1}});
  refuses({ShapeRef(), {1}});
}

TEST_F(Certificates, AHalfSpaceNeedsNoAxis) {
  const auto objects = std::make_shared<const Objects>(Objects(model_).changed(
      {AddObject{makeObject("wall", {{HalfSpace{{-1.0, 0.0, 0.0}, -4.0}}}, Fixed{})}}));  // the points with x >= 4
  const ShapeRef wall = ShapeRef::ofObject(objects->find("wall")), sled = model_->robot.findLink("sled");
  const auto isRight = [&](const ShapeRefPair& pair, double bound) {
    return !flawIn({pair, bound, {{}}}, {{0, 0.5, 1.0}}, *model_, objects.get());
  };
  EXPECT_TRUE(isRight({sled, wall}, 0.5 - 1e-12));
  EXPECT_TRUE(isRight({wall, sled}, 0.5 - 1e-12));
  EXPECT_FALSE(isRight({sled, wall}, 0.5 + 1e-12));
  EXPECT_FALSE(isRight({wall, sled}, 0.5 + 1e-12));
}

/// A ball that is in the wall of a hollow box touches none of its triangles, and so does one in the hollow.
TEST(Certificate, InsideOfAClosedMeshIsNotApart) {
  const auto model = modelOf(urdfOf(link("base") + link("bead", ball("0.1")) +
                                    joint("slide", "prismatic", "base", "bead", axis("1 0 0") + limits("-2", "2"))));
  ObjectOptions options;
  options.meshes.tolerance = 0.0;
  const auto objects = std::make_shared<const Objects>(
      Objects(model).changed({AddObject{makeObject("shell", {{thickShell()}}, Fixed{}, options)}}));
  CertificateNode leaf;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) leaf.axes.push_back({0, sign * Vector3d::Unit(axis)});
  const ShapeRef shell = ShapeRef::ofObject(objects->find("shell")), bead = model->robot.findLink("bead");
  const auto flaw = [&](const ShapeRefPair& pair, double centre) {
    return flawIn({pair, 0.05, {leaf}}, {{0, centre - 0.2, centre + 0.2}}, *model, objects.get()).value_or("");
  };
  for (const ShapeRefPair& pair : {ShapeRefPair{shell, bead}, ShapeRefPair{bead, shell}}) {
    EXPECT_EQ(flaw(pair, 0.0), "") << "in the hollow";
    EXPECT_EQ(flaw(pair, 2.0), "") << "outside";
    EXPECT_EQ(flaw(pair, 1.0), "one of the two is inside of the other one in the middle of the box");
  }
  EXPECT_EQ(flawIn({{shell, bead}, -0.01, {leaf}}, {{0, 0.0, 0.2}}, *model, objects.get()),
            "its bound lets the surfaces of closed meshes meet");
}

}  // namespace proximity_server::scene::certificate_test
