#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>

namespace proximity_server::scene {

/// Stands for all links where some are named.
inline constexpr char kAllLinks[] = "all";

struct ModelOptions {
  double default_padding = 0.0;                       ///< [m] added to every piece as margin
  std::map<std::string, double> link_padding;         ///< [m] replaces default_padding for single links, by name
  double mesh_tolerance = 0.005;                      ///< [m] see MeshOptions::tolerance
  std::map<std::string, double> link_mesh_tolerance;  ///< [m] replaces mesh_tolerance for single links, by name
  std::string mesh_cache;                             ///< see MeshOptions::cache
  double mesh_time_budget = 10.0;                     ///< [s] for each mesh, see MeshOptions::time_budget
  int threads = 0;                                    ///< threads that read meshes; 0: as many as cores
  const std::atomic<bool>* stop = nullptr;            ///< see MeshOptions::stop

  /// Called with link and mesh before a step that takes long; may be empty.
  std::function<void(const std::string&)> progress;

  /// True: a mesh that cannot be read becomes a warning and has no geometry. False: it is an error.
  bool allow_missing_meshes = false;

  /// True: an invalid mimic (of a joint that does not exist or has not one position, of itself, or with a number beyond
  /// 1e6) becomes a warning, and the joint has a position of its own. False: it is an error.
  bool allow_broken_mimics = false;

  /// Links, or kAllLinks, whose <visual> geometry counts if they have no <collision>. See also withLinksOfGroups().
  std::vector<std::string> collision_from_visual;

  /// [m] The value of a link: its own, or the default.
  double paddingOf(const std::string& link) const;
  double meshToleranceOf(const std::string& link) const;
};

}  // namespace proximity_server::scene
