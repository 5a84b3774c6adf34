#pragma once

#include "scene/files.h"

#include <gtest/gtest.h>

#include <string>

namespace proximity_server::scene {

/// The law of refusals: the call throws std::invalid_argument, and its text names what was wrong.
template <typename Call>
testing::AssertionResult isRefused(const Call& call, const std::string& name) {
  const std::string text = errorOf(call);
  if (text.empty()) return testing::AssertionFailure() << "nothing was refused: " << name;
  if (text.find(name) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "\"" << text << "\" does not name \"" << name << "\"";
}

}  // namespace proximity_server::scene
