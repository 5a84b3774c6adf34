#pragma once

#include "proximity_server/scene/guaranteed/guaranteed_distances.h"

#include <cstdint>
#include <optional>
#include <string>

namespace proximity_server::node {

/// Appends why guaranteed distances are coarser than without limits, after `separator`; nothing if they are not.
void appendEnd(std::string& text, const char* separator, const scene::GuaranteedDistances& distances);

/// Returns the end of a text that appendEnd() has appended; "" if it appended nothing.
std::string endIn(const std::string& text);

/// After how many steps the time was over by such a text; nullopt if it was not.
std::optional<std::int64_t> stepsOfTimeOver(const std::string& text);

}  // namespace proximity_server::node
