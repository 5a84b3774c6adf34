#pragma once

#include <chrono>
#include <cstddef>

namespace proximity_server::scene {

// Limits on input files. The files are not trusted, so each limit is checked before memory or time is spent.

/// [m] The largest coordinate. There a double is rounded by 1e-10 m, a tenth of the default tolerance of an answer.
constexpr double kFarthest = 1e6;
/// The end of each message about it.
constexpr const char* kTooFar = "farther than 1e6 m";

// --- meshes

/// The collision meshes of a robot have thousands of triangles. Building the hull of a ball of so many takes 45 s.
constexpr std::size_t kMaxTriangles = 200000;
/// An ASCII STL file with that many triangles has 50 MB; Collada with normals and textures has a few times that.
constexpr std::size_t kMaxBytes = std::size_t{256} << 20;
// The limits on the process that reads one file. A file of 200,000 triangles takes less than a fifth of each.
constexpr std::size_t kMaxReadingMemory = std::size_t{1} << 30;  ///< [byte]
constexpr std::chrono::seconds kMaxReadingProcessorTime{10};
constexpr std::chrono::seconds kMaxReadingTime{60};

// --- XML

/// Elements and attributes together; tinyxml2 needs about 100 bytes for each. The largest robots have a few thousand.
constexpr std::ptrdiff_t kMaxElementsAndAttributes = 1000000;
/// The characters of a name or an attribute: more than any path has. Suggesting the nearest name takes time in
/// proportion to the square of this number.
constexpr std::size_t kLongestAttribute = 1024;

// --- robots

/// Links, and joints: ten times as many as the largest robot that we know has. Their pairs are two million.
constexpr int kMaxLinks = 2000;
/// <collision> elements; finding capsules among them takes time in proportion to the square of their number.
constexpr std::size_t kMaxCollisions = 20000;
/// Convex pieces, each about 1 kB.
constexpr std::size_t kMaxPieces = 1000000;
/// Groups of an SRDF; a group may contain others.
constexpr std::size_t kMaxGroups = 1000;

}  // namespace proximity_server::scene
