// Programs that use the library are compiled with options of their own.
#include "tools/program/run_command.h"

#include <gtest/gtest.h>

namespace proximity_server::scene::client_test {

constexpr int kExitSkipped = 77;  // see client.cpp

// Regression: Isometry3d was aligned to 32 bytes in a client with AVX and to 16 in the library, and fused products gave
// other support points.
TEST(Client, WithAvxAndFusedProductsSeesTheSameLayoutAndTheSameBits) {
  const tools::CommandResult general = tools::runCommand(CLIENT);
  ASSERT_EQ(general.exit_code, 0);
  ASSERT_NE(general.output.find("support point"), std::string::npos);
  const tools::CommandResult haswell = tools::runCommand(HASWELL_CLIENT);
  if (haswell.exit_code == kExitSkipped) GTEST_SKIP() << "this processor has no AVX2";
  ASSERT_EQ(haswell.exit_code, 0);
  EXPECT_EQ(haswell.output, general.output);
}

}  // namespace proximity_server::scene::client_test
