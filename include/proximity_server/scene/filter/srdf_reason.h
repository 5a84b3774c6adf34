#pragma once

#include <string>

namespace proximity_server::scene {

/// True if the reason of a disable_collisions is a person's decision: it begins with "User: ", and says why the pair is
/// not checked although its links come near, or meet. Such a pair causes no warning. MoveIt's assistant writes "Never",
/// "Always", "Default", "Adjacent" and a bare "User", which are none.
bool isDecision(const std::string& srdf_reason);

}  // namespace proximity_server::scene
