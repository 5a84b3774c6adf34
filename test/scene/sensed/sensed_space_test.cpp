// What a camera sees as an object of boxes, against the exact distances of its points.
#include "proximity_server/scene/sensed/voxel_grid.h"

#include "chance.h"
#include "oracle/oracle.h"
#include "scene/objects/object_geometry.h"
#include "scene/query/cell.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace proximity_server::scene::sensed_space_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Cloud = std::vector<Vector3d>;

/// Links of every kind of shape, with a cloud as the object "camera".
struct Seeing : Cell {
  explicit Seeing(double grid_resolution)
      : Cell({box("0.4 0.6 0.8"), ball("0.3"), cylinder("0.1", "0.5") + ball("0.2", "0 0 0.4")}),
        resolution(grid_resolution) {}

  void see(const Cloud& cloud) {
    VoxelGrid grid(resolution);
    for (const Vector3d& point : cloud) grid.add(point);
    const bool is_new = objects()->find("camera") < 0;
    const AddObject camera = add("camera", {{Boxes{grid.boxes()}}}, Fixed{});
    is_new ? change({camera}) : change({ReplaceObject{camera.object}});
  }

  struct Range {
    double least = 1e300, most = 1e300;  ///< [m]
  };
  /// The distance of the nearest point, by formulas in long double.
  Range exactDistance(const Cloud& cloud) {
    Range found;
    const BodyPoses& poses = scene().state.poses();
    for (const Body& body : robot().bodies)
      for (const int number : body.pieces) {
        const Piece& piece = robot().pieces[number];
        const Isometry3d piece_T_world =
            (*poses[robot().links[robot().collisions[piece.collision].link].body] * piece.body_T_piece).inverse();
        for (const Vector3d& point : cloud) {
          const Vector3d in_piece = piece_T_world * point;
          found.least = std::min(found.least, static_cast<double>(narrowphase::outsideBy(piece.shape, in_piece)));
          found.most = std::min(found.most, static_cast<double>(narrowphase::outsideByAtMost(piece.shape, in_piece)));
        }
      }
    return found;
  }

  static Pairs withCamera(PosedScene& scene) { return {scene.candidates(), PairKind::WithObject}; }

  const double resolution;
};

/// On a wavy floor, with some points anywhere.
Cloud randomCloud(Chance& chance, int points) {
  Cloud cloud;
  for (int i = 0; i < points; ++i) {
    const Vector3d at = chance.pose(1.5).translation();
    cloud.emplace_back(at.x(), at.y(), chance.happens(0.9) ? -0.9 + 0.1 * std::sin(5.0 * at.x() + at.y()) : at.z());
  }
  return cloud;
}

/// The lower bound holds for every point, and the upper bound is at most the diagonal of a voxel from the nearest one.
void expectBounds(Seeing& seeing, const Cloud& cloud) {
  const Seeing::Range exact = seeing.exactDistance(cloud);
  const PairProximity* const found = seeing.scene().minimum(Seeing::withCamera(seeing.scene()));
  ASSERT_TRUE(found);
  constexpr double kPoses = 1e-13;  // [m] rounding of the poses of this test
  EXPECT_LE(found->result.lower_bound, exact.most + kPoses);
  if (exact.least > 0.0) {
    EXPECT_GE(found->result.upper_bound, exact.least - std::sqrt(3.0) * seeing.resolution - kPoses);
  }
  Question question;
  question.threshold = exact.most + kPoses;
  EXPECT_TRUE(seeing.scene().first(Seeing::withCamera(seeing.scene()), question));
}

TEST(SensedSpace, IsNoFartherThanAnyPoint) {
  for (const double resolution : {0.005, 0.02, 0.1}) {
    Seeing seeing(resolution);
    Chance chance(6);
    for (int i = 0; i < 40; ++i) {
      const Cloud cloud = randomCloud(chance, 100);
      seeing.see(cloud);
      for (int state = 0; state < 3; ++state) {
        seeing.put({chance.pose(1.0), chance.pose(1.0), chance.pose(1.0)});
        expectBounds(seeing, cloud);
      }
    }
  }
}

TEST(SensedSpace, OfManyBoxesIsAnsweredAsEachBoxAlone) {
  Seeing seeing(0.02);
  Chance chance(7);
  const Cloud cloud = randomCloud(chance, 3000);
  seeing.see(cloud);
  for (int i = 0; i < 20; ++i) {
    seeing.put({chance.pose(1.0), chance.pose(1.0), chance.pose(1.0)});
    expectBounds(seeing, cloud);
    const PairProximity* const skipping = seeing.scene().minimum(Seeing::withCamera(seeing.scene()));
    const PairProximity* const plain = seeing.withoutSkipping().minimum(Seeing::withCamera(seeing.withoutSkipping()));
    EXPECT_NEAR(skipping->result.distance, plain->result.distance, 2e-9);
  }
}

TEST(SensedSpace, HasVolumesThatContainTheirParts) {
  Chance chance(8);
  VoxelGrid grid(0.02);
  for (const Vector3d& point : randomCloud(chance, 3000)) grid.add(point);
  const Object camera = makeObject("camera", {{Boxes{grid.boxes()}}}, Fixed{});
  const auto boxOf = [](const Bounds& bounds) {
    return Eigen::AlignedBox3d(bounds.centre - bounds.half, bounds.centre + bounds.half);
  };
  constexpr double kEnds = 1e-13;  // [m] rounding of chains of transforms, which each volume has of its own
  int parts = 0;
  for (const Volume& volume : camera.geometry->volumes()) {
    Eigen::AlignedBox3d box = boxOf(volume.bounds);
    box.min().array() -= kEnds;
    box.max().array() += kEnds;
    EXPECT_TRUE(volume.bounds.axes.isIdentity(0.0));
    for (const int part : volume.parts)
      if (part >= 0) {
        const Bounds& bounds = camera.geometry->volumes()[part].bounds;
        EXPECT_TRUE(box.contains(boxOf(bounds)));
        EXPECT_LE((bounds.centre - volume.bounds.centre).norm(), volume.bounds.radius);
        EXPECT_GE(volume.bounds.reach, bounds.reach);
        ++parts;
      }
    if (volume.isLeaf()) {
      const Piece& piece = piecesOf(camera)[volume.piece];
      const Vector3d centre = piece.body_T_piece.translation(), half = piece.shape.halfExtents();
      EXPECT_TRUE(box.contains(Eigen::AlignedBox3d(centre - half, centre + half)));
      EXPECT_GE(volume.bounds.radius, half.norm());
    }
  }
  EXPECT_GT(parts, 1000);
}

}  // namespace proximity_server::scene::sensed_space_test
