#include "proximity_server/scene/robot_model.h"

#include <gtest/gtest.h>

namespace proximity_server {
namespace {

TEST(NearestName, HasTheFewestEdits) {
  EXPECT_EQ(nearestName("elbov", {"shoulder", "elbow", "wrist"}), "elbow");
  EXPECT_EQ(nearestName("elbow", {}), "");
}

}  // namespace
}  // namespace proximity_server
