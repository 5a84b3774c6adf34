#include "mesh_cache.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace proximity_server {
namespace {

constexpr const char* kVersion = "proximity_server-partition-1";

/// Source: Fowler, Noll, Vo: FNV-1a, 64 bits.
class Hash {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3ULL;
  }
  void add(const std::string& text) { add(text.data(), text.size()); }
  std::string text() const {
    std::array<char, 17> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(value_));
    return digits.data();
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

std::string keyOf(const TriangleMesh& component, double tolerance) {
  Hash hash;
  hash.add(kVersion);
  hash.add(&tolerance, sizeof tolerance);
  for (const Eigen::Vector3d& vertex : component.vertices) hash.add(vertex.data(), 3 * sizeof(double));
  for (const auto& triangle : component.triangles) hash.add(triangle.data(), 3 * sizeof(int));
  return hash.text();
}

std::string checksumOf(const std::string& content) {
  Hash hash;
  hash.add(content);
  return hash.text();
}

std::string write(const std::string& key, const Partition& partition) {
  std::ostringstream text;
  text << kVersion << '\n' << key << '\n' << partition.size() << '\n';
  for (const int cluster : partition) text << cluster << '\n';
  return text.str();
}

/// Nothing unless the text is exactly what write() makes of a partition of `triangles` triangles for this key.
std::optional<Partition> read(const std::string& text, const std::string& key, std::size_t triangles) {
  std::istringstream stream(text);
  std::string version, found_key;
  std::size_t count = 0;
  if (!(stream >> version >> found_key >> count) || count != triangles) return std::nullopt;
  Partition partition(triangles);
  for (int& cluster : partition) {
    if (!(stream >> cluster) || cluster < 0 || cluster >= static_cast<int>(triangles)) return std::nullopt;
  }
  if (write(key, partition) != text) return std::nullopt;
  return partition;
}

std::filesystem::path fileOf(const std::string& folder, const std::string& key) {
  return std::filesystem::path(folder) / (key + ".partition");
}

/// A name that neither another process nor another thread takes.
std::filesystem::path unfinished(const std::filesystem::path& file) {
  static std::atomic<unsigned> count{0};
  return file.string() + "." + std::to_string(getpid()) + "." + std::to_string(count++);
}

}  // namespace

std::optional<Partition> MeshCache::find(const TriangleMesh& component, double tolerance) const {
  if (folder_.empty()) return std::nullopt;
  const std::string key = keyOf(component, tolerance);
  std::ifstream stream(fileOf(folder_, key), std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  constexpr std::size_t kChecksum = 16;
  if (text.size() < kChecksum) return std::nullopt;
  const std::string content = text.substr(0, text.size() - kChecksum);
  if (text.substr(content.size()) != checksumOf(content)) return std::nullopt;
  return read(content, key, component.triangles.size());
}

std::string MeshCache::store(const TriangleMesh& component, double tolerance, const Partition& partition) const {
  if (folder_.empty()) return {};
  const std::string key = keyOf(component, tolerance);
  const std::filesystem::path file = fileOf(folder_, key), draft = unfinished(file);
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  if (!failed) {
    std::ofstream stream(draft, std::ios::binary);
    const std::string content = write(key, partition);
    stream << content << checksumOf(content);
    stream.close();
    if (stream) std::filesystem::rename(draft, file, failed);
    if (stream && !failed) return {};
  }
  std::error_code ignored;
  std::filesystem::remove(draft, ignored);
  return "mesh cache " + folder_ + " cannot be written" + (failed ? ": " + failed.message() : "") +
         "; decompositions are computed again at each start";
}

}  // namespace proximity_server
