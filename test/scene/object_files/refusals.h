#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace proximity_server::scene {

/// The error of `read`, which must refuse.
template <class Read>
std::string refusalOf(Read read) {
  try {
    read();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was refused";
  return {};
}

}  // namespace proximity_server::scene
