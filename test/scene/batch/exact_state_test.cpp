// One state after the other, without memory: what it decides about pairs is what a new Scene does. That its answers
// are the same to the last bit is in batch_skipping_test.cpp.
#include "scene/batch/exact_state.h"

#include "proximity_server/scene/model/kinematics.h"
#include "sanitized.h"
#include "scene/posed_scene.h"
#include "scene/random_states.h"
#include "scene/two_arms.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace proximity_server::scene::exact_state_test {

class ExactStateOfTwoArms : public testing::Test {
 protected:
  PosedScene freshAt(const Eigen::MatrixXd& states, Eigen::Index state) const {
    PosedScene scene = new_.forAnotherThread();
    scene.update(forwardKinematics(model_->robot, positionsOf(states, state)));
    return scene;
  }
  int pairs() const { return static_cast<int>(batch_->candidates.size()); }

  const std::shared_ptr<const SceneModel> model_ = modelOf(urdfOf(twoArms()));
  const std::shared_ptr<const BatchModel> batch_ = std::make_shared<const BatchModel>(model_);
  const PosedScene new_{model_};
  ExactState exact_{batch_};
};

TEST_F(ExactStateOfTwoArms, AVerdictIsThatOfTheBoundsThatSceneFinds) {
  const Eigen::MatrixXd states = randomStates(model_->robot, repeats(600), 2);
  int below = 0, above = 0;
  for (Eigen::Index i = 0; i < states.rows(); ++i) {
    exact_.place(states, i);
    for (int pair = 0; pair < pairs(); ++pair) {
      const double truth = exact_.proximity(pair).result.distance;
      for (const double distance :
           {0.3, 0.05, 0.0, -0.02, truth, truth - 1e-9, truth + 1e-9, truth - 1e-6, truth + 1e-6}) {
        Question question;
        question.threshold = distance;
        PosedScene scene = freshAt(states, i);
        const PairProximity expected = scene.proximity(batch_->candidates[pair], question);
        const bool is_below = exact_.isBelow(pair, distance);
        ASSERT_EQ(is_below, !(expected.result.lower_bound > distance))
            << "state " << i << ", pair " << pair << ", distance " << distance << " of " << truth;
        ++(is_below ? below : above);
      }
    }
  }
  EXPECT_GT(below, 100);
  EXPECT_GT(above, 100);
}

}  // namespace proximity_server::scene::exact_state_test
