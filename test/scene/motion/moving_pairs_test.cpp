#include "scene/motion/moving_pairs.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "scene/query/half_space.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <vector>

namespace proximity_server::scene::moving_pairs_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

// --- boxes that stand for half-spaces

TEST(HalfSpaceBox, HasTheDistanceOfTheHalfSpaceWithinItsReach) {
  Chance chance(11);
  int overlaps = 0;
  for (int i = 0; i < 3000; ++i) {
    const PlacedHalfSpace half_space{chance.direction(), chance.between(-2.0, 2.0), 0, 2.0};
    const Piece piece{someShape(chance), chance.pose(1.0), 0};
    const HalfSpaceBox box(half_space, boundsOf(piece).reach);
    const double expected = halfSpaceDistance(piece, half_space, {}, 0.0, 1e-9).distance;
    const SignedDistance found =
        signedDistance(piece.shape, box.piece.shape, piece.body_T_piece.inverse() * box.piece.body_T_piece);
    ASSERT_NEAR(found.distance, expected, 2e-9) << i;
    overlaps += expected < 0.0;
  }
  EXPECT_GT(overlaps, 1000);
  EXPECT_LT(overlaps, 2000);
}

// The upper face of the box lies in the plane, also where the plane looks down or hardly off an axis.
TEST(HalfSpaceBox, EndsAtThePlane) {
  const double h = 1e-9;
  for (const Vector3d& direction : {Vector3d(0, 0, 1), Vector3d(0, 0, -1), Vector3d(h, 0, -1), Vector3d(1e-6, h, -1),
                                    Vector3d(1, 0, 0), Vector3d(-1, h, 0), Vector3d(1, 2, 3)}) {
    const PlacedHalfSpace half_space{direction.normalized(), 0.75, 4, 0.75};
    const HalfSpaceBox box(half_space, 3.0);
    EXPECT_LE((box.piece.body_T_piece.linear().col(2) - half_space.normal).norm(), 1e-15) << direction.transpose();
    const Eigen::Matrix3d axes = box.piece.body_T_piece.linear();
    EXPECT_LE((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-15) << direction.transpose();
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-15) << direction.transpose();
    // From the plane down by its height, twice the deepest that something within 3 of the origin gets.
    const double middle = half_space.normal.dot(box.piece.body_T_piece.translation());
    EXPECT_NEAR(middle, 0.75 - (3.0 + 0.75), 1e-14);
    EXPECT_EQ(box.piece.collision, 4);
  }
}

// --- the tree of fixed objects

class ManyFixed : public testing::Test {
 protected:
  ManyFixed() {
    std::vector<ObjectChange> changes;
    for (int i = 0; i < 100; ++i) {
      const Shape cube(Box{{0.1, 0.1, 0.1}});
      changes.push_back(AddObject{makeObject(std::to_string(i), {{cube}}, Fixed{at(i, 5, 0)})});
    }
    use(Objects(model_).changed(changes));
  }
  void use(const Objects& objects) {
    objects_ = std::make_shared<const Objects>(objects);
    pairs_.use(objects_);
  }
  int pairAt(int with_all, int item) {
    BoxTree::Node leaf;
    leaf.item = item;
    return pairs_.pairAt(with_all, leaf);
  }
  void begin(PairKind kind = PairKind::WithObject) { pairs_.begin(Pairs(candidates_, kind), motion_); }

  const std::shared_ptr<const SceneModel> model_ = arm();
  const Candidates candidates_{model_->pairs};
  const RobotMotion motion_ =
      RobotMotion::between(model_->robot, std::vector<double>(5, 0.0), std::vector<double>(5, 1.0));
  std::shared_ptr<const Objects> objects_;
  MovingPairs pairs_{model_, std::make_shared<const Volumes>(model_->robot)};
};

TEST_F(ManyFixed, AreOnePairWithEachLinkThatHasGeometry) {
  begin();
  ASSERT_EQ(pairs_.size(), 5);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(pairs_[i].isOfShapes());
  begin(PairKind::Any);
  EXPECT_EQ(pairs_.size(), 5 + static_cast<int>(candidates_.size()));
  begin(PairKind::OfLinks);
  EXPECT_EQ(pairs_.size(), static_cast<int>(candidates_.size()));
}

TEST_F(ManyFixed, AreSeenAtRest) {
  begin();
  EXPECT_EQ(pairs_[0].bodies.middle(), -1) << "the world is the frame of the poses";
  const int pair = pairAt(0, 7);
  EXPECT_EQ(pairs_.poses().pose(pairs_[pair].bodies.middle(), 0.3).translation().y(), 5.0);
}

TEST_F(ManyFixed, BecomeAPairOnceAtTheirLeaf) {
  begin();
  const int pair = pairAt(2, 7);
  ASSERT_EQ(pair, 5);
  EXPECT_TRUE(pairs_[pair].isOfShapes());
  EXPECT_EQ(pairs_[pair].asked.a.link(), pairs_[2].asked.a.link());
  EXPECT_EQ(pairAt(2, 7), pair);
  EXPECT_EQ(pairAt(3, 7), pair + 1);
}

TEST_F(ManyFixed, AreNoPairIfTheyMayTouchOrHaveGone) {
  ObjectRules rules;
  rules.allowed.set(objects_->object(objects_->fixed().item(3).number)->id, "*", AllowedPairs::Rule::Allowed);
  const std::string gone = objects_->object(objects_->fixed().item(4).number)->id;
  use(objects_->withRules(rules).changed({RemoveObject{gone}}));
  begin();
  EXPECT_EQ(pairAt(0, 3), -1);
  EXPECT_EQ(pairAt(0, 4), -1);
  EXPECT_EQ(pairs_.size(), 5);
}

}  // namespace proximity_server::scene::moving_pairs_test
