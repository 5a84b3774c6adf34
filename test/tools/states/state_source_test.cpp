#include "tools/states/state_source.h"

#include "scene/files.h"
#include "tools/states/arm.h"
#include "tools/states/csv_states.h"

#include <gtest/gtest.h>

#include <sstream>
#include <stdexcept>
#include <vector>

namespace proximity_server::tools::state_source_test {

// A state that the caller refuses ends its block, as one that the source refuses.
TEST(StateSource, ReadsOnBehindAStateThatTheCallerRefuses) {
  std::istringstream csv("elbow\n0\n1\n2\n");
  CsvStates states(csv, "s.csv", arm());
  const auto refuseOne = [](const scene::Positions& positions) {
    if (positions[joint("elbow")] == 1.0) throw std::invalid_argument("refused");
  };
  Eigen::MatrixXd block(3, static_cast<Eigen::Index>(arm().joints.size()));
  EXPECT_EQ(states.read(block, refuseOne), 1);
  EXPECT_EQ(scene::errorOf([&] { states.read(block, refuseOne); }), "refused");
  EXPECT_EQ(states.read(block, refuseOne), 1);
  EXPECT_EQ(block(0, joint("elbow")), 2.0);
  EXPECT_EQ(states.read(block, refuseOne), 0);
}

}  // namespace proximity_server::tools::state_source_test
