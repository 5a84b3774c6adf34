#pragma once

#include "proximity_server/Clearance.h"

#include <std_msgs/ColorRGBA.h>

namespace proximity_server::node {

/// The colour in which a level is drawn.
inline std_msgs::ColorRGBA levelColour(Clearance::_level_type level) {
  const auto colour = [](float r, float g, float b) {
    std_msgs::ColorRGBA result;
    result.r = r;
    result.g = g;
    result.b = b;
    result.a = 1.0f;
    return result;
  };
  switch (level) {
    case Clearance::CLEAR:
      return colour(0.2f, 0.8f, 0.2f);
    case Clearance::WARN:
      return colour(1.0f, 0.8f, 0.0f);
    case Clearance::STOP:
      return colour(1.0f, 0.4f, 0.0f);
    case Clearance::COLLISION:
      return colour(1.0f, 0.2f, 0.2f);
    default:
      return colour(1.0f, 0.3f, 1.0f);
  }
}

}  // namespace proximity_server::node
