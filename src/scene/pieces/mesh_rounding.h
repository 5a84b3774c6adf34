#pragma once

namespace proximity_server::scene {

// Mesh files hold floats or six-digit texts: a coordinate of one metre is rounded by up to 1e-6 m.
constexpr double kMeshRounding = 1e-6;

}  // namespace proximity_server::scene
