#include "proximity_server/scene/mesh/mesh.h"

#include "proximity_server/scene/mesh/readable_file.h"
#include "scene/mesh/input_limits.h"
#include "scene/mesh/mesh_file.h"
#include "scene/mesh/mesh_import.h"
#include "scene/mesh/stop_flag.h"
#include "system/child_process.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

// --- before a file is read

/// Checks the file and returns its size [byte].
std::size_t checkFile(const std::string& path) {
  if (const std::string why = whyUnreadable(path); !why.empty())
    throw std::invalid_argument("cannot be read (" + why + ")");
  // A pipe is refused, because one could wait for it for ever.
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed)) throw std::invalid_argument("is no file");
  const std::uintmax_t size = std::filesystem::file_size(path, failed);
  if (failed) throw std::invalid_argument(failed.message());
  if (size > kMaxBytes) throw std::invalid_argument("it has " + std::to_string(size) + " bytes, more than 256 MiB");
  return size;
}

std::string inLowerCase(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return text;
}

/// The suffix of a file name in lower case, with the dot.
std::string extensionOf(const std::string& path) {
  return inLowerCase(std::filesystem::path(path).extension().string());
}

/// Reads at most `count` bytes.
std::string bytesOf(const std::string& path, std::size_t begin, std::size_t count) {
  std::string bytes(count, '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(begin));
  stream.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(stream.gcount());
  return bytes;
}

constexpr std::size_t kStlCount = 80, kStlFacets = 84, kStlFacet = 50;  // positions and size in a binary file [byte]

/// True if an STL file is a text, which may begin with a byte order mark. No binary file below kMaxBytes can declare so
/// many triangles that the count has no zero byte.
bool isText(const std::string& stl_header) {
  const std::size_t first = std::min(stl_header.find_first_not_of(" \t\r\n\xEF\xBB\xBF"), stl_header.size());
  return inLowerCase(stl_header.substr(first, 5)) == "solid" && stl_header.find('\0') == std::string::npos;
}

/// Reads an ASCII STL file in the form that assimp knows: without a byte order mark, and with keywords in lower case.
/// All other files are "".
std::string stlText(const std::string& path, std::size_t size) {
  if (extensionOf(path) != ".stl" || !isText(bytesOf(path, 0, kStlFacets))) return "";
  std::string text = inLowerCase(bytesOf(path, 0, size));
  return text.erase(0, text.find("solid"));
}

/// Requires the last line of an ASCII STL file: "endsolid NAME" or "end solid NAME".
void checkEnd(const std::string& path, std::size_t size) {
  constexpr std::size_t kLastLine = 4096;
  std::string end = inLowerCase(bytesOf(path, size - std::min(size, kLastLine), kLastLine));
  end.erase(std::remove_if(end.begin(), end.end(), [](char c) { return c == ' ' || c == '\t'; }), end.end());
  // The first of several solids may be complete.
  const std::size_t last = end.rfind("endsolid"), next_line = end.find('\n', last);
  if (last == std::string::npos || end.find("facet", next_line) != std::string::npos)
    throw std::invalid_argument("it is cut off: \"endsolid\" is missing");
}

/// Refuses STL files that assimp accepts silently or refuses with an unclear message.
void checkStl(const std::string& path, std::size_t size) {
  const std::string header = bytesOf(path, 0, kStlFacets);
  if (isText(header)) return checkEnd(path, size);
  if (header.size() < kStlFacets) throw std::invalid_argument("it is shorter than the header of a binary STL file");
  std::uint32_t declared = 0;  // little endian, like the machines on which this runs
  std::memcpy(&declared, header.data() + kStlCount, sizeof declared);
  const std::size_t present = (size - kStlFacets) / kStlFacet;
  if (declared > present) {
    throw std::invalid_argument("its header declares " + std::to_string(declared) + " triangles, but only " +
                                std::to_string(present) + " are there");
  }
  if (const std::size_t end = kStlFacets + kStlFacet * declared; end < size) {
    throw std::invalid_argument("its header declares " + std::to_string(declared) + " triangles, which end at byte " +
                                std::to_string(end) + ", but it has " + std::to_string(size) + " bytes");
  }
}

struct PlyElement {
  long count = 0;
  std::vector<bool> properties;  // true: a list, which begins with its length
};

/// Reads the elements that an ASCII PLY file declares; none for a binary file. Leaves the stream after the header.
std::vector<PlyElement> plyTextElements(std::istream& stream) {
  std::vector<PlyElement> elements;
  for (std::string line; std::getline(stream, line) && line.compare(0, 10, "end_header") != 0;) {
    std::istringstream words(line);
    std::string keyword, second;
    words >> keyword >> second;
    if (keyword == "format" && second != "ascii") return {};
    if (keyword == "element" && !(words >> elements.emplace_back().count)) elements.pop_back();
    if (keyword == "property" && !elements.empty()) elements.back().properties.push_back(second == "list");
  }
  return elements;
}

/// assimp accepts a text with missing faces; in a binary file it notices that bytes are missing.
void checkPly(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string word;
  for (const PlyElement& element : plyTextElements(stream)) {
    for (long i = 0; i < element.count && !element.properties.empty(); ++i) {
      for (const bool is_list : element.properties) {
        long words = 1;
        if (is_list) stream >> words;
        for (long k = 0; k < words && stream; ++k) stream >> word;
        if (!stream) throw std::invalid_argument("it is cut off: it has fewer vertices or faces than it declares");
      }
    }
  }
}

void checkFormat(const std::string& path, std::size_t size) {
  const std::string extension = extensionOf(path);
  if (extension == ".stl") {
    checkStl(path, size);
  } else if (extension == ".ply") {
    checkPly(path);
  } else if (extension != ".dae" && extension != ".obj") {
    throw std::invalid_argument("only .stl, .dae, .obj and .ply files are read");
  }
}

}  // namespace

void checkMesh(const TriangleMesh& mesh) {
  if (mesh.triangles.size() > kMaxTriangles)
    throw std::invalid_argument("the mesh has more than " + std::to_string(kMaxTriangles) + " triangles");
  for (const Vector3d& vertex : mesh.vertices) {
    if (!vertex.allFinite()) throw std::invalid_argument("a vertex of the mesh is not finite");
    if (vertex.cwiseAbs().maxCoeff() <= kFarthest) continue;
    std::ostringstream text;
    text << "a vertex of the mesh is at (" << vertex.transpose() << ") m, " << kTooFar << " from its origin";
    throw std::invalid_argument(text.str());
  }
  const int count = static_cast<int>(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles)
    for (const int vertex : triangle)
      if (vertex < 0 || vertex >= count)
        throw std::invalid_argument("a triangle of the mesh names vertex " + std::to_string(vertex) + " of " +
                                    std::to_string(count));
}

MeshWithUnit readMesh(const std::string& path, const Vector3d& scale, const std::atomic<bool>* stop) try {
  if (!scale.allFinite() || (scale.array() == 0.0).any()) {
    throw std::invalid_argument("its scale must be finite and not zero");
  }
  const std::size_t size = checkFile(path);
  checkFormat(path, size);
  const system::ProcessLimits limits{kMaxReadingMemory, kMaxReadingProcessorTime, kMaxReadingTime, maxBytesOfMesh(),
                                     stop};
  const auto bytes = [&] { return toBytes(importMesh(path, stlText(path, size), scale)); };
  MeshWithUnit read = meshFromBytes(system::answerOfChild(bytes, limits));
  if (read.mesh.triangles.empty()) throw std::invalid_argument("it has no triangle");
  checkMesh(read.mesh);
  return read;
} catch (const std::exception& error) {
  requireNoStop(stop);
  throw std::invalid_argument("mesh " + path + ": " + error.what());
}

TriangleMesh loadMesh(const std::string& path, const Vector3d& scale) { return readMesh(path, scale).mesh; }

std::string unitRemark(double unit) {
  if (unit == 1.0) return "";
  std::ostringstream text;
  text << "a Collada file with a unit of " << unit << " m, so its lengths are multiplied by " << unit
       << ", as in RViz; MoveIt takes them as metres. All agree if it is exported in metres";
  return text.str();
}

}  // namespace proximity_server::scene
