#pragma once

#include <atomic>
#include <stdexcept>

namespace proximity_server::scene {

/// Throws std::runtime_error once the flag of MeshOptions::stop is set. It is no std::invalid_argument, so that nobody
/// takes it for a mesh that cannot be read.
inline void requireNoStop(const std::atomic<bool>* stop) {
  if (stop && stop->load(std::memory_order_relaxed)) throw std::runtime_error("the loading of meshes is stopped");
}

}  // namespace proximity_server::scene
