#include "scene/pieces/mesh_cache.h"

#include "system/fnv_hash.h"
#include "system/whole_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

constexpr const char* kVersion = "proximity_server-pieces-11";

std::string keyOf(const TriangleMesh& mesh, double tolerance, double time_budget) {
  system::FnvHash hash;
  hash.add(kVersion);
  hash.add(&tolerance, sizeof tolerance);
  hash.add(&time_budget, sizeof time_budget);
  for (const Eigen::Vector3d& vertex : mesh.vertices) hash.add(vertex.data(), 3 * sizeof(double));
  for (const auto& triangle : mesh.triangles) hash.add(triangle.data(), 3 * sizeof(int));
  return hash.text();
}

std::string checksumOf(const std::string& content) {
  system::FnvHash hash;
  hash.add(content);
  return hash.text();
}

std::uint64_t bitsOf(double number) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &number, sizeof bits);
  return bits;
}

/// Reads a number that was written as bitsOf() it. Returns false if there is no integer.
bool readBits(std::istream& stream, double& number) {
  std::uint64_t bits = 0;
  if (!(stream >> bits)) return false;
  std::memcpy(&number, &bits, sizeof number);
  return true;
}

std::string write(const std::string& key, const Clustering& clustering) {
  std::ostringstream text;
  text << kVersion << '\n' << key << '\n' << static_cast<int>(clustering.representation) << '\n';
  text << (clustering.is_complete ? "complete" : "stopped") << '\n';
  text << bitsOf(clustering.deviation) << '\n' << bitsOf(clustering.uncovered) << '\n';
  text << bitsOf(clustering.volume_ratio) << '\n' << bitsOf(clustering.tolerance) << '\n';
  text << clustering.partition.size() << '\n';
  for (const int cluster : clustering.partition) text << cluster << '\n';
  return text.str();
}

/// Returns nullopt unless the text is exactly what write() returns for a clustering of `triangles` triangles and this
/// key.
std::optional<Clustering> read(const std::string& text, const std::string& key, std::size_t triangles) {
  std::istringstream stream(text);
  std::string version, found_key, completeness;
  int representation = 0;
  std::size_t count = 0;
  Clustering result;
  if (!(stream >> version >> found_key >> representation >> completeness)) return std::nullopt;
  if (!readBits(stream, result.deviation) || !readBits(stream, result.uncovered) ||
      !readBits(stream, result.volume_ratio) || !readBits(stream, result.tolerance) || !(stream >> count) ||
      count != triangles) {
    return std::nullopt;
  }
  if (representation < 0 || representation > static_cast<int>(Representation::Triangles)) return std::nullopt;
  result.representation = static_cast<Representation>(representation);
  result.is_complete = completeness == "complete";
  result.partition.resize(triangles);
  for (int& cluster : result.partition) {
    if (!(stream >> cluster) || cluster < 0 || cluster >= static_cast<int>(triangles)) return std::nullopt;
  }
  if (write(key, result) != text) return std::nullopt;
  return result;
}

/// True if these numbers can be a result of convexPieces. Written so that NaN is refused.
bool isPlausible(const Clustering& clustering, double tolerance) {
  const bool is_exact = clustering.representation == Representation::Exact;
  // Only rooms that were not excluded when the effort was spent are deeper than the tolerance.
  const bool has_open_rooms = !clustering.is_complete && !is_exact;
  const double largest = is_exact         ? kMeshRounding
                         : has_open_rooms ? std::numeric_limits<double>::max()
                                          : std::max(tolerance, kMeshRounding);
  const double ratio = clustering.volume_ratio;
  return clustering.tolerance >= tolerance && std::isfinite(clustering.tolerance) && clustering.deviation >= 0.0 &&
         clustering.deviation <= largest && clustering.uncovered >= 0.0 && std::isfinite(clustering.uncovered) &&
         (std::isnan(ratio) || (ratio >= 0.0 && std::isfinite(ratio)));
}

std::filesystem::path fileOf(const std::string& folder, const std::string& key) {
  return std::filesystem::path(folder) / (key + ".pieces");
}

}  // namespace

MeshCache::MeshCache(std::string folder, const TriangleMesh& mesh, double tolerance, double time_budget)
    : folder_(std::move(folder)),
      key_(folder_.empty() ? "" : keyOf(mesh, tolerance, time_budget)),
      triangles_(mesh.triangles.size()),
      tolerance_(tolerance) {}

std::optional<Clustering> MeshCache::find() const {
  if (folder_.empty()) return std::nullopt;
  std::ifstream stream(fileOf(folder_, key_), std::ios::binary);
  std::ostringstream read_text;
  read_text << stream.rdbuf();  // which, unlike its iterators, does not throw where nothing can be read, as of a folder
  const std::string text = read_text.str();
  constexpr std::size_t kChecksum = 16;
  if (text.size() < kChecksum) return std::nullopt;
  const std::string content = text.substr(0, text.size() - kChecksum);
  if (text.substr(content.size()) != checksumOf(content)) return std::nullopt;
  const std::optional<Clustering> found = read(content, key_, triangles_);
  return found && isPlausible(*found, tolerance_) ? found : std::nullopt;
}

std::string MeshCache::store(const Clustering& clustering) const {
  if (folder_.empty()) return {};
  const auto because = [&](const std::string& reason) {
    return "mesh cache " + folder_ + " cannot be written: " + reason +
           "; decompositions are computed again at each start";
  };
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  if (failed) return because(failed.message());
  try {
    const std::string content = write(key_, clustering);
    system::replaceFile(fileOf(folder_, key_), content + checksumOf(content));
  } catch (const std::invalid_argument& error) {
    return because(error.what());
  }
  return {};
}

}  // namespace proximity_server::scene
