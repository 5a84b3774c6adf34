#include "node/tf/edge_transforms.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::node::edge_transforms_test {

/// A turn about z by `angle` [rad], with a quaternion of the given length.
geometry_msgs::Transform turn(double angle, double length) {
  geometry_msgs::Transform transform;
  transform.rotation.z = length * std::sin(0.5 * angle);
  transform.rotation.w = length * std::cos(0.5 * angle);
  return transform;
}

// The squares of these lengths are off by 0.008 and by 0.012; the limit is 0.01, as in tf.
TEST(RigidMotion, TurnsByTheDirectionOfAQuaternionWhoseLengthIsNearlyOne) {
  const auto motion = rigidMotion(turn(0.5 * M_PI, 1.004));
  ASSERT_TRUE(motion);
  EXPECT_TRUE(motion->linear().col(0).isApprox(Eigen::Vector3d::UnitY(), 1e-15));
  EXPECT_FALSE(rigidMotion(turn(0.5 * M_PI, 1.006)));
  EXPECT_FALSE(rigidMotion(turn(0.5 * M_PI, 0.99)));
}

// tf lets such a length pass, whose square is no number.
TEST(RigidMotion, HasNoLengthWhoseSquareOverflows) {
  geometry_msgs::Transform transform = turn(0.0, 1.0);
  transform.translation.x = 1e150;
  EXPECT_TRUE(rigidMotion(transform));
  transform.translation.x = 1e160;
  EXPECT_FALSE(rigidMotion(transform));
}

}  // namespace proximity_server::node::edge_transforms_test
