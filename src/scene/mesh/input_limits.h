#pragma once

#include <chrono>
#include <cstddef>

namespace proximity_server::scene {

// Limits on input files. The files are not trusted, so each limit is checked before memory or time is spent.

/// [m] Largest coordinate: there a double is rounded by 1e-10 m, a tenth of the default tolerance of an answer.
constexpr double kFarthest = 1e6;

// --- meshes

/// A robot's collision meshes have thousands. Building the hull of a ball of so many takes 45 s.
constexpr std::size_t kMaxTriangles = 200000;
/// An ASCII STL file of so many has 50 MB; Collada with normals and textures takes a few times that.
constexpr std::size_t kMaxBytes = std::size_t{256} << 20;
// Limits on the process that reads one file. A file of 200,000 triangles takes less than a tenth of each.
constexpr std::size_t kMaxReadingMemory = std::size_t{1} << 30;  ///< [byte]
constexpr std::chrono::seconds kMaxReadingProcessorTime{10};
constexpr std::chrono::seconds kMaxReadingTime{60};

// --- XML

/// Elements and attributes together; tinyxml2 takes about 100 bytes for each. The largest robots have a few thousand.
constexpr std::ptrdiff_t kMaxElementsAndAttributes = 1000000;
/// Characters of a name or an attribute: more than of any path. Suggesting the nearest name takes the square of them.
constexpr std::size_t kLongestAttribute = 1024;

// --- robots

/// Links, and joints: ten times the largest robot that we know. Their pairs are two million.
constexpr int kMaxLinks = 2000;
/// <collision> elements; finding capsules among them takes the square of their number.
constexpr std::size_t kMaxCollisions = 20000;
/// Convex pieces, about 1 kB each.
constexpr std::size_t kMaxPieces = 1000000;
/// Groups of an SRDF; a group may contain others.
constexpr std::size_t kMaxGroups = 1000;

}  // namespace proximity_server::scene
