#pragma once

#include "proximity_server/scene/mesh/mesh.h"
#include "robots/urdf.h"
#include "scene/files.h"
#include "scene/pieces/boxes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

// Closed meshes that are not convex, and an oracle for them that shares nothing with the library.

namespace proximity_server::scene {

/// The points (x, y, z) with 0 <= z <= 1, 0 <= x, y <= 2, and x <= 1 or y <= 1: one closed part of 20 triangles.
inline TriangleMesh bracket() {
  const double corners[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  TriangleMesh mesh;
  for (const double z : {0.0, 1.0})
    for (const auto& corner : corners) mesh.vertices.emplace_back(corner[0], corner[1], z);
  for (int i = 1; i < 5; ++i) {
    mesh.triangles.push_back({0, i + 1, i});
    mesh.triangles.push_back({6, 6 + i, 7 + i});
  }
  for (int i = 0; i < 6; ++i) {
    const int next = (i + 1) % 6;
    mesh.triangles.push_back({i, next, 6 + next});
    mesh.triangles.push_back({i, 6 + next, 6 + i});
  }
  return mesh;
}

/// A box of edge 3 about the origin, with a cavity of edge 1 about it.
inline TriangleMesh thickShell() {
  return together({boxMesh(Eigen::Vector3d::Constant(-1.5), Eigen::Vector3d::Constant(3.0)),
                   boxMesh({0.5, -0.5, -0.5}, {-1.0, 1.0, 1.0})});
}

/// A ball of radius 0.3 with dents as deep as 6 cm: hulls of its surface leave the middle empty.
inline TriangleMesh dentedBall() {
  constexpr int kRings = 12, kSides = 20;
  const auto point = [](double polar, double around) {
    const double dent = 0.06 * std::pow(std::sin(3.0 * polar) * std::sin(3.0 * around), 2);
    const Eigen::Vector3d direction(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                                    std::cos(polar));
    // Rounded, so that a file in single precision keeps it.
    return Eigen::Vector3d(((0.3 - dent) * direction * 0x1p20).array().round() * 0x1p-20);
  };
  TriangleMesh mesh;
  mesh.vertices = {point(0.0, 0.0), point(M_PI, 0.0)};
  for (int ring = 1; ring < kRings; ++ring)
    for (int side = 0; side < kSides; ++side)
      mesh.vertices.push_back(point(ring * M_PI / kRings, side * 2.0 * M_PI / kSides));
  const auto at = [](int ring, int side) { return 2 + (ring - 1) * kSides + side % kSides; };
  for (int side = 0; side < kSides; ++side) {
    mesh.triangles.push_back({0, at(1, side), at(1, side + 1)});
    mesh.triangles.push_back({1, at(kRings - 1, side + 1), at(kRings - 1, side)});
    for (int ring = 1; ring + 1 < kRings; ++ring) {
      mesh.triangles.push_back({at(ring, side), at(ring + 1, side), at(ring + 1, side + 1)});
      mesh.triangles.push_back({at(ring, side), at(ring + 1, side + 1), at(ring, side + 1)});
    }
  }
  return mesh;
}

/// A closed ball of 0.6 m with bumps of 2 cm, of about 2 * rows * columns triangles.
inline TriangleMesh bumpyBall(int rows, int columns) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, 0.3);
  for (int i = 1; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double t = M_PI * i / rows, p = 2.0 * M_PI * j / columns;
      const double r = 0.3 * (1.0 + 0.08 * std::sin(t) * std::sin(13.0 * t) * std::cos(11.0 * p));
      mesh.vertices.emplace_back(r * std::sin(t) * std::cos(p), r * std::sin(t) * std::sin(p), r * std::cos(t));
    }
  }
  mesh.vertices.emplace_back(0.0, 0.0, -0.3);
  const auto at = [&](int i, int j) { return 1 + (i - 1) * columns + j % columns; };
  const int last = static_cast<int>(mesh.vertices.size()) - 1;
  for (int j = 0; j < columns; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    mesh.triangles.push_back({last, at(rows - 1, j + 1), at(rows - 1, j)});
    for (int i = 1; i + 1 < rows; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

inline TriangleMesh scaled(TriangleMesh mesh, double factor) {
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= factor;
  return mesh;
}

inline Eigen::AlignedBox3d boxAround(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

/// A binary .stl file, which keeps single precision.
inline std::string stlOf(const TriangleMesh& mesh) {
  std::string bytes(80, ' ');
  const auto append = [&](const auto& number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);  // NOLINT(*-reinterpret-cast)
  };
  append(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) append(0.0F);  // the normal
    for (const int corner : triangle)
      for (int i = 0; i < 3; ++i) append(static_cast<float>(mesh.vertices[corner][i]));
    append(std::uint16_t{0});
  }
  return bytes;
}

// --- the oracle

/// How often the mesh winds around a point: the sum of the solid angles of its triangles over 4 pi.
/// Source: van Oosterom, Strackee, The Solid Angle of a Plane Triangle, 1983.
inline double windingNumber(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  double angle = 0.0;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[triangle[0]] - p, b = mesh.vertices[triangle[1]] - p,
                          c = mesh.vertices[triangle[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * M_PI);
}

/// [m] The distance of a point from a triangle: the smallest one over the plane, if its foot is inside, and the edges.
inline double distanceOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                         const Eigen::Vector3d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d corners[3] = {a, b, c};
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d from = corners[i], edge = corners[(i + 1) % 3] - from;
    const double along = std::clamp(edge.dot(p - from) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (from + along * edge - p).norm());
  }
  const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
  const auto side = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return normal.dot((to - from).cross(p - from));
  };
  if (side(a, b) >= 0.0 && side(b, c) >= 0.0 && side(c, a) >= 0.0)
    nearest = std::min(nearest, std::abs(normal.dot(p - a)));
  return nearest;
}

/// [m] The signed distance of a point from the solid inside a closed mesh, negative inside.
inline double distanceFromSolid(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : mesh.triangles)
    nearest = std::min(nearest, distanceOf(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], p));
  return std::abs(windingNumber(mesh, p)) > 0.5 ? -nearest : nearest;
}

/// <collision> elements of meshes.
class Meshes {
 public:
  std::string of(const TriangleMesh& mesh, const std::string& xyz = "0 0 0") {
    return robots::mesh(files_.write(std::to_string(count_++) + ".stl", stlOf(mesh)), xyz);
  }

 private:
  TemporaryFiles files_;
  int count_ = 0;
};

}  // namespace proximity_server::scene
