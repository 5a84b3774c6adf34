#include "scene/batch/batch_model.h"

#include "scene/batch/verdicts.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene::batch_model_test {

/// y and z hardly move and are 0.02 apart; x is at least 0.3 from both.
std::shared_ptr<const BatchModel> twoThatAreNear() {
  const auto onRailAt = [](const std::string& name, const std::string& xyz, const std::string& range) {
    return link(name, ball("0.1")) +
           joint("to_" + name, "prismatic", "rail", name, origin(xyz) + axis("1 0 0") + limits("-" + range, range));
  };
  return std::make_shared<const BatchModel>(
      modelOf(urdfOf(link("rail") + onRailAt("x", "0 0 0", "9") + onRailAt("y", "0 0.5 0", "0.01") +
                     onRailAt("z", "0 0.72 0", "0.01"))));
}

TEST(BatchModel, BeginsWithThePairThatIsNearMostOften) {
  const auto batch = twoThatAreNear();
  ASSERT_EQ(batch->candidates[2].a.link(), batch->model->robot.findLink("y"));
  EXPECT_EQ(batch->order, (std::vector<int>{2, 0, 1}));
}

TEST(Verdicts, NameTheFirstPairOfThatOrderIfSeveralAreBelow) {
  Verdicts verdicts(twoThatAreNear());
  EXPECT_EQ(verdicts.anyBelow(Eigen::MatrixXd::Zero(1, 3), 10.0)[0].pair, 2);
}

}  // namespace proximity_server::scene::batch_model_test
