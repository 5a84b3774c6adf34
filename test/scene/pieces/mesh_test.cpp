#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "sanitized.h"
#include "scene/files.h"
#include "scene/pieces/boxes.h"
#include "scene/pieces/mesh_parts.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace proximity_server::scene::mesh_test {

using namespace narrowphase;

using Eigen::Vector3d;

const Vector3d kUnscaled(1, 1, 1);

// --- meshes on paper

/// A box from `low` to `high`, its twelve triangles counter-clockwise from outside.
TriangleMesh box(const Vector3d& low, const Vector3d& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// Every triangle with vertices of its own, as an STL file has it.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh result;
  for (const auto& triangle : mesh.triangles) {
    const int first = static_cast<int>(result.vertices.size());
    for (const int corner : triangle) result.vertices.push_back(mesh.vertices[corner]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

void expectBounds(const TriangleMesh& mesh, const Vector3d& low, const Vector3d& high) {
  // Floats of the file, and of a unit like 0.001.
  const double rounding = 2.0 * std::numeric_limits<float>::epsilon() * boxAround(mesh).max().cwiseAbs().maxCoeff();
  EXPECT_LE((boxAround(mesh).min() - low).cwiseAbs().maxCoeff(), rounding) << boxAround(mesh).min().transpose();
  EXPECT_LE((boxAround(mesh).max() - high).cwiseAbs().maxCoeff(), rounding) << boxAround(mesh).max().transpose();
}

// --- the same as files

template <typename T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string binaryStl(const TriangleMesh& mesh, std::string header, std::uint32_t declared) {
  header.resize(80, ' ');
  put(header, declared);
  for (const auto& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) put(header, 0.0F);
    for (const int corner : triangle) {
      for (int i = 0; i < 3; ++i) put(header, static_cast<float>(mesh.vertices[corner][i]));
    }
    put(header, std::uint16_t{0});
  }
  return header;
}

std::string binaryStl(const TriangleMesh& mesh, const std::string& header = "made by a test") {
  return binaryStl(mesh, header, static_cast<std::uint32_t>(mesh.triangles.size()));
}

std::string asciiStl(const TriangleMesh& mesh) {
  std::ostringstream text;
  text << "solid test\n";
  for (const auto& triangle : mesh.triangles) {
    text << "facet normal 0 0 0\nouter loop\n";
    for (const int corner : triangle) text << "vertex " << mesh.vertices[corner].transpose() << "\n";
    text << "endloop\nendfacet\n";
  }
  text << "endsolid test\n";
  return text.str();
}

/// The unit box in quads.
const char* const kBoxObj =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

/// One triangle (0, 0, 0), (1, 0, 0), (0, 2, 0) in a Collada file with these nodes.
std::string collada(const std::string& asset, const std::string& scene_nodes, const std::string& library_nodes = "") {
  return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>)" +
         asset + R"(</asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 2 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_nodes>)" +
         library_nodes + R"(</library_nodes>
<library_visual_scenes><visual_scene id="s">)" +
         scene_nodes + R"(</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

class MeshFile : public ::testing::Test {
 protected:
  TriangleMesh load(const std::string& name, const std::string& content, const Vector3d& scale = kUnscaled) {
    return loadMesh(files_.write(name, content), scale);
  }
  /// The text of the error of loading.
  std::string error(const std::string& name, const std::string& content, const Vector3d& scale = kUnscaled) {
    return errorOf([&] { load(name, content, scale); });
  }
  TemporaryFiles files_;
};

const TriangleMesh kBox = box({0, 0, 0}, {1, 2, 3});

TEST_F(MeshFile, BinaryAndAsciiStlGiveTheSameBox) {
  for (const std::string& content : {binaryStl(kBox), asciiStl(kBox)}) {
    const TriangleMesh mesh = load("box.stl", content);
    EXPECT_EQ(mesh.triangles.size(), 12U);
    EXPECT_DOUBLE_EQ(enclosedVolume(mesh), 6.0);
    expectBounds(mesh, {0, 0, 0}, {1, 2, 3});
  }
}

TEST_F(MeshFile, BinaryStlThatBeginsWithSolidIsToldByItsSize) {
  EXPECT_EQ(load("box.stl", binaryStl(kBox, "solid exported by a CAD system")).triangles.size(), 12U);
}

TEST_F(MeshFile, ObjPolygonsBecomeTriangles) {
  const TriangleMesh mesh = load("box.obj", kBoxObj);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_DOUBLE_EQ(enclosedVolume(mesh), 1.0);
}

TEST_F(MeshFile, ObjIndicesMayCountFromTheEnd) {
  EXPECT_EQ(load("triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n").triangles.size(), 1U);
}

/// An ASCII or binary (little endian) PLY file with quadrangles and an attribute that nobody asked for.
std::string plyOfUnitBox(const std::string& format) {
  std::string ply = "ply\nformat " + format +
                    " 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nproperty float "
                    "confidence\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n";
  const bool is_text = format == "ascii";
  const auto put = [&](auto value) {
    is_text ? ply.append(std::to_string(value) + " ") : ply.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (int i = 0; i < 8; ++i) {
    for (const int bit : {1, 2, 4}) put(i & bit ? 1.0F : 0.0F);
    put(0.5F);
    if (is_text) ply += "\n";
  }
  for (const auto& face :
       {std::array<int, 4>{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    put(std::uint8_t{4});
    for (const int corner : face) put(corner);
    if (is_text) ply += "\n";
  }
  return ply;
}

TEST_F(MeshFile, PlyIsReadAsTextAndAsBytes) {
  for (const std::string format : {"ascii", "binary_little_endian"}) {
    const TriangleMesh mesh = load("box.ply", plyOfUnitBox(format));
    EXPECT_EQ(mesh.triangles.size(), 12U) << format;
    EXPECT_DOUBLE_EQ(enclosedVolume(mesh), 1.0) << format;
  }
}

TEST_F(MeshFile, PlyThatIsCutOffInItsLastFacesThrows) {
  for (const std::string format : {"ascii", "binary_little_endian"}) {
    const std::string whole = plyOfUnitBox(format);
    for (std::size_t missing = 4; missing < 40; missing += 3) {
      EXPECT_NE(error("broken.ply", whole.substr(0, whole.size() - missing)), "") << format << ", " << missing;
    }
  }
}

TEST_F(MeshFile, ScaleStretchesEachAxis) {
  expectBounds(load("box.stl", binaryStl(kBox), {2, 10, 0.001}), {0, 0, 0}, {2, 20, 0.003});
}

TEST_F(MeshFile, MirroredScaleKeepsTrianglesFacingOutwards) {
  for (const Vector3d& scale : {Vector3d(1, -1, 1), Vector3d(-1, -1, 1), Vector3d(-1, -1, -1)}) {
    EXPECT_DOUBLE_EQ(enclosedVolume(load("box.stl", binaryStl(kBox), scale)), 6.0) << scale.transpose();
  }
}

TEST_F(MeshFile, ColladaUpAxisIsIgnored) {
  for (const std::string axis : {"X_UP", "Y_UP", "Z_UP"}) {
    const TriangleMesh mesh =
        load("t.dae", collada("<up_axis>" + axis + "</up_axis>", R"(<node><instance_geometry url="#g"/></node>)"));
    expectBounds(mesh, {0, 0, 0}, {1, 2, 0});
  }
}

TEST_F(MeshFile, ColladaUnitCounts) {
  const TriangleMesh mesh = load(
      "t.dae", collada(R"(<unit name="millimeter" meter="0.001"/>)", R"(<node><instance_geometry url="#g"/></node>)"));
  expectBounds(mesh, {0, 0, 0}, {0.001, 0.002, 0});
}

TEST_F(MeshFile, ColladaNodeTransformsAndInstancesCount) {
  const TriangleMesh mesh = load("t.dae", collada("<up_axis>Y_UP</up_axis>",
                                                  R"(<node><translate>5 0 0</translate>
                                                       <node><rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node>
                                                     </node>
                                                     <node><translate>0 0 7</translate><instance_node url="#n"/></node>)",
                                                  R"(<node id="n"><instance_geometry url="#g"/></node>)"));
  EXPECT_EQ(mesh.triangles.size(), 2U);
  // The first turned about z and moved to x = 5: x in [3, 5], y in [0, 1]. The second at z = 7.
  expectBounds(mesh, {0, 0, 0}, {5, 2, 7});
}

TEST_F(MeshFile, ColladaNodeThatMirrorsKeepsTheFacing) {
  const TriangleMesh mesh =
      load("t.dae", collada("", R"(<node><scale>-1 1 1</scale><instance_geometry url="#g"/></node>)"));
  const auto& [a, b, c] = mesh.triangles.at(0);
  const Vector3d normal = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
  EXPECT_GT(normal.z(), 0.0);
}

TEST_F(MeshFile, DegenerateTrianglesAreTolerated) {
  TriangleMesh mesh = box({0, 0, 0}, {1, 1, 1});
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({2, 2, 2});
  const MeshPieces pieces = convexPieces(load("box.stl", binaryStl(mesh)));
  EXPECT_EQ(pieces.representation, Representation::Exact);
  ASSERT_EQ(pieces.hulls.size(), 1U);
  EXPECT_EQ(pieces.hulls[0].size(), 8);
}

// Each broken file must name itself, whatever is wrong with it.
TEST_F(MeshFile, BrokenFilesThrowNamingTheFile) {
  const TriangleMesh none;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string whole = binaryStl(kBox);
  const struct {
    const char* what;
    const char* name;
    std::string content;
  } cases[] = {
      {"empty file", "broken.stl", ""},
      {"shorter than a header", "broken.stl", "STL"},
      {"no triangle, binary", "broken.stl", binaryStl(none)},
      {"no triangle, ASCII", "broken.stl", "solid nothing\nendsolid nothing\n"},
      {"cut off", "broken.stl", whole.substr(0, whole.size() / 2)},
      {"a billion triangles declared", "broken.stl", binaryStl(kBox, "huge", 1000000000U)},
      {"a billion declared in a file that begins with solid", "broken.stl", binaryStl(kBox, "solid", 1000000000U)},
      {"NaN, binary", "broken.stl", binaryStl({{{nan, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}})},
      {"NaN, ASCII", "broken.stl", asciiStl({{{nan, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}})},
      {"no mesh at all", "broken.stl", "This is a text."},
      {"index out of range", "broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"},
      {"points only", "broken.obj", "v 0 0 0\nv 1 0 0\n"},
      {"lines only", "broken.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"},
      {"infinite", "broken.obj", "v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"no XML", "broken.dae", "<COLLADA"},
      {"no scene", "broken.dae", "<COLLADA/>"},
      {"nothing in the scene", "broken.dae", collada("", "<node/>")},
      {"PLY, cut off", "broken.ply", plyOfUnitBox("ascii").substr(0, 300)},
      {"PLY in bytes, cut off", "broken.ply", plyOfUnitBox("binary_little_endian").substr(0, 360)},
      {"PLY with a billion faces declared", "broken.ply",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "1000000000\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"},
      {"unknown format", "broken.xyz", "0 0 0"},
  };
  for (const auto& broken : cases) {
    EXPECT_NE(error(broken.name, broken.content).find(broken.name), std::string::npos) << broken.what;
  }
}

TEST_F(MeshFile, MissingFileAndFolderThrowNamingThem) {
  EXPECT_NE(errorOf([&] { loadMesh(files_.path("absent.stl"), kUnscaled); }).find("absent.stl"), std::string::npos);
  EXPECT_NE(errorOf([&] { loadMesh(files_.path(""), kUnscaled); }).find(files_.path("")), std::string::npos);
}

TEST_F(MeshFile, ScaleOfZeroOrNanThrows) {
  EXPECT_NE(error("box.stl", binaryStl(kBox), {1, 0, 1}), "");
  EXPECT_NE(error("box.stl", binaryStl(kBox), {1, std::nan(""), 1}), "");
}

// --- convex pieces

/// A tolerance in which the coarsest representation is near enough.
MeshOptions within(double tolerance) {
  MeshOptions options;
  options.tolerance = tolerance;
  return options;
}
const MeshOptions kCoarse = within(2.0);

TEST(ConvexPieces, BoxIsExactlyItsHull) {
  const MeshPieces pieces = convexPieces(soup(box({-1, -1, -1}, {1, 1, 1})));
  ASSERT_EQ(pieces.hulls.size(), 1U);
  EXPECT_EQ(pieces.hulls[0].size(), 8);
  EXPECT_EQ(pieces.representation, Representation::Exact);
  EXPECT_LE(pieces.deviation, 1e-15);
}

TEST(ConvexPieces, SeparateBoxesAreExactlyTheirHulls) {
  TriangleMesh mesh = box({0, 0, 0}, {1, 1, 1});
  mesh = together({mesh, box({2, 0, 0}, {3, 1, 1})});
  mesh = together({mesh, box({0, 5, 0}, {1, 6, 1})});
  const MeshPieces pieces = convexPieces(soup(mesh));
  EXPECT_EQ(pieces.hulls.size(), 3U);
  EXPECT_EQ(pieces.representation, Representation::Exact);
}

TEST(ConvexPieces, PlusAndMinusZeroAreTheSamePlace) {
  TriangleMesh mesh = soup(box({0, 0, 0}, {1, 1, 1}));
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 2) {
    for (int k = 0; k < 3; ++k) mesh.vertices[i][k] = mesh.vertices[i][k] == 0.0 ? -0.0 : mesh.vertices[i][k];
  }
  EXPECT_EQ(convexPieces(mesh).hulls.size(), 1U);
}

TEST(ConvexPieces, ComponentInsideAnotherIsNoPieceOfItsOwn) {
  TriangleMesh mesh = box({0.4, 0.4, 0.4}, {0.6, 0.6, 0.6});
  mesh = together({mesh, box({0, 0, 0}, {1, 1, 1})});
  mesh = together({mesh, box({0, 0, 0}, {1, 1, 1})});
  const MeshPieces pieces = convexPieces(mesh);
  ASSERT_EQ(pieces.hulls.size(), 1U);
  EXPECT_DOUBLE_EQ(pieces.hulls[0].volume(), 1.0);
  EXPECT_EQ(pieces.representation, Representation::Exact);
}

/// An L of two legs of length `leg` and thickness 1, 1 deep: the hull bridges its corner.
TriangleMesh angle(double leg) {
  const std::vector<Eigen::Vector2d> outline{{0, 0}, {leg, 0}, {leg, 1}, {1, 1}, {1, leg}, {0, leg}};
  TriangleMesh mesh;
  for (const double z : {0.0, 1.0}) {
    for (const auto& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.push_back({i, j, 6 + i});
    mesh.triangles.push_back({j, 6 + j, 6 + i});
  }
  for (const std::array<int, 3>& t : {std::array<int, 3>{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}}) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({6 + t[0], 6 + t[1], 6 + t[2]});
  }
  return mesh;
}

TEST(ConvexPieces, AngleIsItsHullWithinACoarseToleranceAndSaysHowFarThatLies) {
  const MeshPieces pieces = convexPieces(soup(angle(3)), kCoarse);
  EXPECT_EQ(pieces.hulls.size(), 1U);
  EXPECT_EQ(pieces.representation, Representation::ConvexHull);
  // The bridge from (3, 1) to (1, 3) is farthest from the legs' inner sides in its middle, (2, 2): 1 from either.
  EXPECT_NEAR(pieces.deviation, 1.0, 0.01);
  EXPECT_LE(pieces.deviation, 1.0 + 1e-12);
}

TEST(ConvexPieces, AngleBesideABoxIsTheirTwoHullsWithinACoarseTolerance) {
  TriangleMesh mesh = angle(3);
  mesh = together({mesh, box({10, 0, 0}, {11, 1, 1})});
  const MeshPieces pieces = convexPieces(mesh, kCoarse);
  EXPECT_EQ(pieces.hulls.size(), 2U);
  EXPECT_EQ(pieces.representation, Representation::Decomposed);
  EXPECT_NEAR(pieces.deviation, 1.0, 0.01);
}

// A pit of 0.02 x 0.02, 1e-3 deep, in a box 200 times as large: no grid of samples would find it.
TEST(ConvexPieces, SmallPitIsFound) {
  TriangleMesh mesh = box({0, 0, 0}, {4, 4, 4});
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);  // the top
  const int rim = static_cast<int>(mesh.vertices.size());
  const Vector3d centre(1.3, 2.1, 4.0);
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    mesh.vertices.push_back(centre + 0.01 * Vector3d(x, y, 0));
  }
  mesh.vertices.push_back(centre - Vector3d(0, 0, 1e-3));
  const int corner[] = {4, 5, 7, 6};
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    mesh.triangles.push_back({corner[i], corner[j], rim + i});
    mesh.triangles.push_back({corner[j], rim + j, rim + i});
    mesh.triangles.push_back({rim + i, rim + j, rim + 4});
  }
  const MeshPieces pieces = convexPieces(mesh);
  EXPECT_EQ(pieces.representation, Representation::ConvexHull);
  // From above the pit's deepest point to its walls, which fall 1e-3 on 0.01: 1e-3 * cos(atan(0.1)).
  EXPECT_NEAR(pieces.deviation, 1e-3 / std::sqrt(1.01), 1e-9);
}

TEST(ConvexPieces, OpenBoxIsItsHullWithALidWithinACoarseTolerance) {
  TriangleMesh mesh = box({0, 0, 0}, {2, 2, 2});
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);  // the top
  const MeshPieces pieces = convexPieces(mesh, kCoarse);
  EXPECT_EQ(pieces.representation, Representation::ConvexHull);
  EXPECT_NEAR(pieces.deviation, 1.0, 0.01);  // the middle of the lid to the nearest wall
}

TEST(ConvexPieces, FlatPlateIsExactlyItsPolygon) {
  const MeshPieces pieces = convexPieces({{{0, 0, 1}, {2, 0, 1}, {2, 1, 1}, {0, 1, 1}}, {{0, 1, 2}, {0, 2, 3}}});
  ASSERT_EQ(pieces.hulls.size(), 1U);
  EXPECT_EQ(pieces.hulls[0].dimension(), 2);
  EXPECT_EQ(pieces.representation, Representation::Exact);
}

TEST(ConvexPieces, TriangleWithoutAreaIsASegment) {
  const MeshPieces pieces = convexPieces({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 1, 2}}});
  ASSERT_EQ(pieces.hulls.size(), 1U);
  EXPECT_EQ(pieces.hulls[0].dimension(), 1);
}

// --- concave meshes

/// The closed surface that a profile in x and z sweeps about the z axis, in so many `steps`.
TriangleMesh revolved(const std::vector<Eigen::Vector2d>& profile, int steps) {
  TriangleMesh mesh;
  const int count = static_cast<int>(profile.size());
  for (int s = 0; s < steps; ++s) {
    const double turn = 2.0 * std::acos(-1.0) * s / steps;
    for (const auto& p : profile) mesh.vertices.emplace_back(p.x() * std::cos(turn), p.x() * std::sin(turn), p.y());
  }
  for (int s = 0; s < steps; ++s) {
    for (int i = 0; i < count; ++i) {
      const int a = s * count + i, b = s * count + (i + 1) % count;
      const int c = (s + 1) % steps * count + i, d = (s + 1) % steps * count + (i + 1) % count;
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({b, c, d});
    }
  }
  return mesh;
}

struct ConcaveMesh {
  const char* name;
  TriangleMesh mesh;
};
const ConcaveMesh kConcave[] = {
    {"L", scaled(angle(3), 0.1)},
    {"ring", revolved({{0.1, -0.02}, {0.14, -0.02}, {0.14, 0.02}, {0.1, 0.02}}, 32)},
    // Its wall is 1 cm thick; the profile crosses the axis nowhere, a narrow hole goes through its floor.
    {"cup", revolved({{0.001, 0}, {0.05, 0}, {0.05, 0.1}, {0.04, 0.1}, {0.04, 0.01}, {0.001, 0.01}}, 24)},
};

/// To the nearest of many points: shares no code with the measurement under test.
double distanceToSamples(const Vector3d& p, const std::vector<Vector3d>& samples) {
  double best = std::numeric_limits<double>::infinity();
  for (const Vector3d& sample : samples) best = std::min(best, (sample - p).squaredNorm());
  return std::sqrt(best);
}

/// Points of a triangle, at most `step` apart from a next one.
void sample(const Vector3d& a, const Vector3d& b, const Vector3d& c, double step, std::vector<Vector3d>& samples) {
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  const int n = static_cast<int>(std::ceil(longest / step));
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) samples.push_back(a + (b - a) * i / n + (c - a) * j / n);
  }
}

/// Whether p lies in the solid that these meshes are, from their definitions.
bool inSolid(const std::string& name, const Vector3d& p) {
  const double radius = p.head<2>().norm();
  if (name == "L") {
    const bool in_square = p.minCoeff() >= 0 && p.x() <= 0.3 && p.y() <= 0.3 && p.z() <= 0.1;
    return in_square && (p.x() <= 0.1 || p.y() <= 0.1);
  }
  if (name == "ring") return radius >= 0.1 && radius <= 0.14 && std::abs(p.z()) <= 0.02;
  return p.z() >= 0 && p.z() <= 0.1 && radius <= 0.05 && (radius >= 0.04 || p.z() <= 0.01);
}

TEST(ConcaveMeshes, PiecesLieWithinTheToleranceOfTheMeshByIndependentSampling) {
  for (const ConcaveMesh& concave : kConcave) {
    constexpr double kStep = kIsSanitized ? 0.01 : 0.003;
    std::vector<Vector3d> surface;
    for (const auto& [a, b, c] : concave.mesh.triangles) {
      sample(concave.mesh.vertices[a], concave.mesh.vertices[b], concave.mesh.vertices[c], kStep, surface);
    }
    for (const double tolerance : {0.02, 0.005}) {
      if (kIsSanitized && tolerance < 0.01) continue;
      const MeshPieces pieces = convexPieces(soup(concave.mesh), within(tolerance));
      EXPECT_EQ(pieces.representation == Representation::Exact, pieces.deviation <= 1e-6) << concave.name;
      EXPECT_LT(pieces.hulls.size(), concave.mesh.triangles.size()) << concave.name;
      EXPECT_LE(pieces.deviation, tolerance) << concave.name;
      EXPECT_LE(pieces.uncovered, 1e-9) << concave.name;
      double farthest = 0.0;
      for (const ConvexHull& hull : pieces.hulls) {
        std::vector<Vector3d> points;
        for (const auto& [a, b, c] : hull.triangles()) {
          sample(hull.vertices()[a], hull.vertices()[b], hull.vertices()[c], 4 * kStep, points);
        }
        for (const Vector3d& p : points) {
          if (!inSolid(concave.name, p)) farthest = std::max(farthest, distanceToSamples(p, surface));
        }
      }
      EXPECT_LE(farthest, tolerance + kStep) << concave.name;
    }
  }
}

TEST(ConcaveMeshes, AnLIsNearlyTwoBoxes) {
  const MeshPieces pieces = convexPieces(kConcave[0].mesh);
  EXPECT_EQ(pieces.hulls.size(), 2U);
}

TEST(ConcaveMeshes, WithToleranceZeroAreTheirTriangles) {
  for (const ConcaveMesh& concave : kConcave) {
    const MeshPieces pieces = convexPieces(concave.mesh, within(0.0));
    EXPECT_EQ(pieces.representation, Representation::Triangles) << concave.name;
    EXPECT_EQ(pieces.hulls.size(), concave.mesh.triangles.size()) << concave.name;
    EXPECT_EQ(pieces.deviation, 0.0);
  }
}

TEST(ConcaveMeshes, HullsThatAreExactNeedNoTrianglesWithToleranceZero) {
  TriangleMesh mesh = box({0, 0, 0}, {1, 1, 1});
  mesh = together({mesh, box({2, 0, 0}, {3, 1, 1})});
  const MeshPieces pieces = convexPieces(mesh, within(0.0));
  EXPECT_EQ(pieces.hulls.size(), 2U);
  EXPECT_EQ(pieces.representation, Representation::Exact);
}

// The L fills 5 of the 9 squares of its outline; its hull lacks half of the 2 x 2 square in the corner: 7 of them.
TEST(ConcaveMeshes, VolumeRatioIsThatOfTheHullToTheMesh) {
  EXPECT_NEAR(convexPieces(soup(angle(3)), kCoarse).volume_ratio, 7.0 / 5.0, 1e-9);
  EXPECT_NEAR(convexPieces(kBox).volume_ratio, 1.0, 1e-12);
}

TEST(ConcaveMeshes, VolumeRatioOfAnOpenMeshIsNotANumber) {
  TriangleMesh mesh = kBox;
  mesh.triangles.pop_back();
  EXPECT_TRUE(std::isnan(convexPieces(mesh).volume_ratio));
}

TEST(ConcaveMeshes, BadMeshesAreStillCovered) {
  TriangleMesh mesh = scaled(angle(3), 0.01);
  mesh.triangles.pop_back();                    // open
  mesh.triangles.push_back({0, 0, 1});          // no area
  mesh.triangles.push_back({0, 4, 8});          // a third triangle at an edge
  mesh.triangles.push_back(mesh.triangles[0]);  // twice
  const MeshPieces pieces = convexPieces(mesh, within(5e-5));
  EXPECT_LE(pieces.deviation, 5e-5);
  EXPECT_LE(pieces.uncovered, 1e-9);
}

/// Triangles in one component of which no two fit into one piece.
TriangleMesh star(int triangles) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, 0.0);
  std::srand(7);
  for (int i = 0; i < triangles; ++i) {
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(Vector3d::Random());
    mesh.vertices.push_back(Vector3d::Random());
    mesh.triangles.push_back({0, first, first + 1});
  }
  return mesh;
}

TEST(ConcaveMeshes, WhereTheTimeBudgetEndsThePiecesSoFarStandForTheMesh) {
  MeshOptions options;
  options.time_budget = 0.1;
  const MeshPieces pieces = convexPieces(star(1500), options);
  EXPECT_EQ(pieces.hulls.size(), 1500U);
  EXPECT_EQ(pieces.representation, Representation::Triangles);
  EXPECT_NE(pieces.shortfall.find("1500 triangles"), std::string::npos) << pieces.shortfall;
  EXPECT_NE(pieces.shortfall.find("time budget of 0.1 s"), std::string::npos) << pieces.shortfall;
}

// Ever smaller budgets: as many steps are counted each time, so the pieces are the same. They say how far they lie from
// the mesh, which has no rooms.
TEST(ConcaveMeshes, AnyTimeBudgetGivesTheSamePiecesEachTimeWithATrueBound) {
  int cut_short = 0;
  for (double budget = kIsSanitized ? 0.001 : 1.0; budget > 1e-6; budget *= 0.3) {
    MeshOptions options;
    options.time_budget = budget;
    const MeshPieces pieces = convexPieces(kConcave[2].mesh, options), again = convexPieces(kConcave[2].mesh, options);
    cut_short += !pieces.shortfall.empty();
    EXPECT_GE(pieces.tolerance, options.tolerance) << budget;
    EXPECT_LE(pieces.tolerance, 8.0 * options.tolerance) << budget;
    EXPECT_EQ(pieces.tolerance, again.tolerance) << budget;
    EXPECT_EQ(pieces.deviation, again.deviation) << budget;
    EXPECT_LE(pieces.uncovered, 1e-9) << budget;
    ASSERT_EQ(pieces.hulls.size(), again.hulls.size()) << budget;
    for (std::size_t i = 0; i < pieces.hulls.size(); ++i)
      EXPECT_EQ(pieces.hulls[i].vertices(), again.hulls[i].vertices()) << budget;
  }
  EXPECT_GT(cut_short, 2);
}

TEST(ConcaveMeshes, TimeBudgetThatIsNotAboveZeroThrows) {
  MeshOptions options;
  for (const double budget : {0.0, -1.0, std::nan("")}) {
    options.time_budget = budget;
    EXPECT_NE(errorOf([&] { convexPieces(kBox, options); }), "");
  }
}

/// A rectangle of squares of side 0.01, each two triangles, in the plane z = 0.
TriangleMesh grid(int columns, int rows) {
  TriangleMesh mesh;
  for (int y = 0; y <= rows; ++y) {
    for (int x = 0; x <= columns; ++x) mesh.vertices.emplace_back(0.01 * x, 0.01 * y, 0.0);
  }
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const int a = y * (columns + 1) + x, b = a + columns + 1;
      mesh.triangles.push_back({a, a + 1, b});
      mesh.triangles.push_back({a + 1, b + 1, b});
    }
  }
  return mesh;
}

// Two walls of a corner, 20,000 triangles in all: halving and fusing is fast where a try for each pair would not be.
TEST(ConcaveMeshes, FineTrianglesOfTwoWallsBecomeTwoPieces) {
#ifdef PROXIMITY_SANITIZED
  GTEST_SKIP() << "a second without a sanitizer";
#endif
  TriangleMesh mesh = grid(100, 50), wall = grid(100, 50);
  for (Vector3d& vertex : wall.vertices) vertex = Vector3d(vertex.x(), 0.0, vertex.y());
  mesh = together({mesh, wall});
  const MeshPieces pieces = convexPieces(mesh);
  EXPECT_EQ(pieces.hulls.size(), 2U);
  EXPECT_EQ(pieces.shortfall, "");
}

// The budget counts steps: it ends at the same one on every machine. The pieces cover every vertex.
TEST(ConcaveMeshes, ABumpyBallBecomesFewPiecesWithinItsTimeBudget) {
#ifdef PROXIMITY_SANITIZED
  GTEST_SKIP() << "seconds without a sanitizer";
#endif
  const TriangleMesh mesh = bumpyBall(32, 64);
  const MeshPieces pieces = convexPieces(mesh);
  EXPECT_EQ(pieces.shortfall, "");
  EXPECT_LE(pieces.hulls.size(), mesh.triangles.size() / 5);
  EXPECT_GT(pieces.hulls.size(), 10U);
  EXPECT_LE(pieces.deviation, MeshOptions{}.tolerance);
  EXPECT_LE(pieces.uncovered, 1e-9);
}

// Regression: where the budget ended, the triangles that were not yet merged stood for the mesh, thousands of them.
TEST(ConcaveMeshes, ATooDearMeshGetsFewPiecesWithinACoarserToleranceAndSaysSo) {
  MeshOptions options;
  options.time_budget = 0.3;
  const TriangleMesh mesh = bumpyBall(32, 64);
  const MeshPieces pieces = convexPieces(mesh, options);
  EXPECT_LE(pieces.hulls.size(), 300U);
  EXPECT_GT(pieces.tolerance, options.tolerance);
  EXPECT_LE(pieces.tolerance, 8.0 * options.tolerance);
  EXPECT_GT(pieces.deviation, options.tolerance);
  EXPECT_LE(pieces.deviation, pieces.tolerance);
  EXPECT_LE(pieces.uncovered, 1e-9);
  EXPECT_NE(pieces.shortfall.find("instead of the tolerance of 0.005 m"), std::string::npos) << pieces.shortfall;
}

TEST(ConcaveMeshes, NegativeOrNanToleranceThrows) {
  EXPECT_NE(errorOf([] { convexPieces(kBox, within(-1e-3)); }), "");
  EXPECT_NE(errorOf([] { convexPieces(kBox, within(std::nan(""))); }), "");
}

// --- cache

class Cache : public ::testing::Test {
 protected:
  /// The pieces of the mesh, from the cache or not.
  MeshPieces pieces(double tolerance = 0.02) {
    MeshOptions options = within(tolerance);
    options.cache = folder_;
    options.progress = [this](const std::string&) { ++decomposed_; };
    options.time_budget = time_budget_;
    return convexPieces(mesh_, options);
  }
  std::vector<std::filesystem::path> stored() const {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) found.push_back(entry.path());
    return found;
  }
  std::string content() const { return readFile(stored().at(0)); }
  void overwrite(const std::string& text) const { std::ofstream(stored().at(0), std::ios::binary) << text; }

  TemporaryFiles files_;
  std::string folder_ = files_.path("cache/of/meshes");
  TriangleMesh mesh_ = kConcave[1].mesh;
  double time_budget_ = 10.0;
  int decomposed_ = 0;
};

void expectSame(const MeshPieces& a, const MeshPieces& b) {
  ASSERT_EQ(a.hulls.size(), b.hulls.size());
  for (std::size_t i = 0; i < a.hulls.size(); ++i) EXPECT_EQ(a.hulls[i].vertices(), b.hulls[i].vertices());
  EXPECT_EQ(a.representation, b.representation);
  EXPECT_EQ(a.deviation, b.deviation);
}

TEST_F(Cache, SecondTimeGivesTheSamePiecesWithoutDecomposing) {
  const MeshPieces first = pieces();
  EXPECT_EQ(decomposed_, 1);
  EXPECT_EQ(stored().size(), 1U);
  expectSame(first, pieces());
  EXPECT_EQ(decomposed_, 1);
}

TEST_F(Cache, AnotherToleranceIsAnotherEntry) {
  pieces(0.02);
  pieces(0.01);
  EXPECT_EQ(decomposed_, 2);
  EXPECT_EQ(stored().size(), 2U);
}

TEST_F(Cache, AnotherTimeBudgetIsAnotherEntry) {
  pieces();
  time_budget_ = 20.0;
  pieces();
  EXPECT_EQ(decomposed_, 2);
  EXPECT_EQ(stored().size(), 2U);
}

// Romeo, 15 s at each start: deviations were measured again.
TEST_F(Cache, WhatWasMeasuredIsKeptToo) {
  const MeshPieces first = pieces();
  EXPECT_GT(first.deviation, 1e-4);
  EXPECT_GT(first.volume_ratio, 1.0);
  const MeshPieces again = pieces();
  EXPECT_EQ(again.deviation, first.deviation);
  EXPECT_EQ(again.uncovered, first.uncovered);
  EXPECT_EQ(again.volume_ratio, first.volume_ratio);
}

// HyQ, 5 s at each start: that its trunk takes too long was found out again.
TEST_F(Cache, ThatTheTimeBudgetEndedIsKeptWithItsReason) {
  mesh_ = star(1500);
  time_budget_ = 0.1;
  const MeshPieces first = pieces();
  EXPECT_EQ(decomposed_, 1);
  const MeshPieces again = pieces();
  EXPECT_EQ(decomposed_, 1);
  EXPECT_EQ(again.hulls.size(), 1500U);
  EXPECT_NE(first.shortfall, "");
  EXPECT_EQ(again.shortfall, first.shortfall);
}

/// The checksum of a file of the cache: FNV-1a, 64 bits.
std::string checksum(const std::string& content) {
  std::uint64_t value = 0xcbf29ce484222325ULL;
  for (const char byte : content) value = (value ^ static_cast<unsigned char>(byte)) * 0x100000001b3ULL;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(value));
  return digits.data();
}

// Even a file with the right checksum is not believed in what convexPieces would not have accepted.
TEST_F(Cache, ImpossibleNumbersAreNotBelieved) {
  const MeshPieces first = pieces();
  const std::string whole = content();
  std::vector<std::string> lines;
  std::istringstream stream(whole.substr(0, whole.size() - 16));
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  const auto bits = [](double number) {
    std::uint64_t pattern = 0;
    std::memcpy(&pattern, &number, sizeof pattern);
    return std::to_string(pattern);
  };
  ASSERT_EQ(lines.at(4), bits(first.deviation));
  const auto with = [&](std::size_t line, const std::string& text) {
    std::vector<std::string> changed = lines;
    changed.at(line) = text;
    std::string content;
    for (const std::string& each : changed) content += each + "\n";
    return content + checksum(content);
  };
  overwrite(with(4, bits(first.deviation)));
  decomposed_ = 0;
  pieces();
  EXPECT_EQ(decomposed_, 0);  // so it was written as the cache writes it
  overwrite(with(4, bits(0.001)));
  EXPECT_EQ(pieces().deviation, 0.001);  // so it is not measured again
  for (const std::string& broken :
       {with(4, bits(0.021)), with(4, bits(-1.0)), with(4, bits(std::nan(""))), with(5, bits(std::nan(""))),
        with(2, "0"), with(2, "9"), with(7, bits(0.001)), with(9, "-1"), with(9, "100000"), with(8, "1")}) {
    overwrite(broken);
    decomposed_ = 0;
    expectSame(first, pieces());
    EXPECT_EQ(decomposed_, 1);
    EXPECT_EQ(content(), whole);
  }
}

TEST_F(Cache, BrokenFilesAreRebuilt) {
  const MeshPieces first = pieces();
  const std::string whole = content();
  std::string flipped = whole;
  flipped[flipped.size() / 2] = flipped[flipped.size() / 2] == '1' ? '2' : '1';
  for (const std::string& broken : {std::string(), std::string("short"), whole.substr(0, whole.size() / 2), flipped,
                                    whole + " ", std::string(5000, '\0')}) {
    overwrite(broken);
    decomposed_ = 0;
    expectSame(first, pieces());
    EXPECT_EQ(decomposed_, 1) << broken.size();
    EXPECT_EQ(content(), whole);
  }
}

// A file in the place of the folder: even root cannot write there.
// The flag is set when the mesh is about to be decomposed.
TEST_F(Cache, KeepsNothingOfAMeshThatIsStopped) {
  std::atomic<bool> stop{false};
  MeshOptions options = within(0.02);
  options.cache = folder_;
  options.stop = &stop;
  options.progress = [&](const std::string&) { stop = true; };
  EXPECT_THROW(convexPieces(mesh_, options), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(folder_));
  EXPECT_THROW(convexPieces(mesh_, options), std::runtime_error) << "the flag is set from the start";

  stop = false;
  options.progress = nullptr;
  const MeshPieces later = convexPieces(mesh_, options);
  EXPECT_EQ(stored().size(), 1U);
  expectSame(later, convexPieces(mesh_, within(0.02)));
}

TEST_F(Cache, PlaceThatCannotBeWrittenIsAWarning) {
  folder_ = files_.write("occupied", "a file");
  const MeshPieces found = pieces();
  EXPECT_GT(found.hulls.size(), 1U);
  ASSERT_EQ(found.warnings.size(), 1U);
  EXPECT_NE(found.warnings[0].find("occupied"), std::string::npos);
}

// Regression: the warning named the folder only.
TEST_F(Cache, WarningNamesTheFileAndTheReason) {
  pieces();
  const std::filesystem::path file = stored().at(0);
  std::filesystem::remove(file);
  std::filesystem::create_directory(file);
  const MeshPieces found = pieces();
  ASSERT_EQ(found.warnings.size(), 1U);
  EXPECT_EQ(found.warnings[0], "mesh cache " + folder_ + " cannot be written: " + file.string() +
                                   ": is a folder, not a file; decompositions are computed again at each start");
  EXPECT_EQ(stored().size(), 1U);
}

TEST(UserMeshCache, IsWhereXdgSays) {
  setenv("XDG_CACHE_HOME", "/there", 1);
  EXPECT_EQ(userMeshCache(), "/there/proximity_server");
  unsetenv("XDG_CACHE_HOME");
  setenv("HOME", "/home/me", 1);
  EXPECT_EQ(userMeshCache(), "/home/me/.cache/proximity_server");
}

// --- resolver

class Resolver : public ::testing::Test {
 protected:
  Resolver() {
    files_.write("src/arms/left/package.xml", "<package format='2'>\n<name> left_arm </name></package>");
    files_.write("src/arms/left/meshes/a.stl", "left");
    files_.write("src/arms/left/nested/package.xml", "<package><name>nested</name></package>");
    files_.write("src/arms/left/nested/a.stl", "nested");
    files_.write("src/ignored/CATKIN_IGNORE", "");
    files_.write("src/ignored/package.xml", "<package><name>ignored</name></package>");
    files_.write("src/ignored/a.stl", "ignored");
    files_.write("overlay/left/package.xml", "<package><name>left_arm</name></package>");
    files_.write("overlay/left/meshes/a.stl", "overlay");
    files_.write("src/broken/package.xml", "<package>");
  }
  MeshResolver resolver() { return packageResolver({files_.path("src")}, files_.path("src/arms")); }
  TemporaryFiles files_;
};

TEST_F(Resolver, FindsPackagesByTheNameInPackageXmlWithTwoOrThreeSlashes) {
  const std::string mesh = files_.path("src/arms/left/meshes/a.stl");
  EXPECT_EQ(resolver()("package://left_arm/meshes/a.stl"), mesh);
  EXPECT_EQ(resolver()("package:///left_arm/meshes/a.stl"), mesh);
}

TEST_F(Resolver, FileAndPlainPathsAreTakenAsTheyAre) {
  const std::string mesh = files_.path("src/arms/left/meshes/a.stl");
  EXPECT_EQ(resolver()("file://" + mesh), mesh);
  EXPECT_EQ(resolver()(mesh), mesh);
  EXPECT_EQ(resolver()("left/meshes/a.stl"), mesh);
}

TEST_F(Resolver, FirstRootWins) {
  const MeshResolver resolve = packageResolver({files_.path("overlay"), files_.path("src")});
  EXPECT_EQ(resolve("package://left_arm/meshes/a.stl"), files_.path("overlay/left/meshes/a.stl"));
}

TEST_F(Resolver, RootMayBeThePackageItself) {
  const MeshResolver resolve = packageResolver({files_.path("overlay/left")});
  EXPECT_EQ(resolve("package://left_arm/meshes/a.stl"), files_.path("overlay/left/meshes/a.stl"));
}

TEST_F(Resolver, DoesNotLookInsidePackagesOrIgnoredFolders) {
  EXPECT_NE(errorOf([&] { resolver()("package://nested/a.stl"); }), "");
  EXPECT_NE(errorOf([&] { resolver()("package://ignored/a.stl"); }), "");
}

TEST_F(Resolver, LinksInACircleEnd) {
  files_.link("src", "src/arms/again");
  EXPECT_NE(errorOf([&] { resolver()("package://absent/a.stl"); }), "");
}

TEST_F(Resolver, WhatCannotBeOpenedThrowsNamingTheUri) {
  for (const std::string uri : {"package://absent/a.stl", "package://left_arm/absent.stl", "package://left_arm",
                                "package://", "file:///absent.stl", "absent.stl", "http://host/a.stl", ""}) {
    const std::string said = errorOf([&] { resolver()(uri); });
    EXPECT_FALSE(said.empty()) << uri;
    EXPECT_NE(said.find(uri), std::string::npos) << said;
  }
}

TEST_F(Resolver, DecodesThePercentEncodingOfUrisAndNotOfPlainPaths) {
  const std::string mesh = files_.write("src/arms/left/meshes/upper arm.stl", "blank");
  EXPECT_EQ(resolver()("package://left_arm/meshes/upper%20arm.stl"), mesh);
  EXPECT_EQ(resolver()("package://left_arm/meshes/upper%20%61rm.stl"), mesh);
  EXPECT_EQ(resolver()("file://" + files_.path("src/arms/left/meshes/upper%20arm.stl")), mesh);
  EXPECT_EQ(resolver()("package://left_arm/meshes/upper arm.stl"), mesh);
  EXPECT_NE(errorOf([&] { resolver()("left/meshes/upper%20arm.stl"); }), "");
  const std::string odd = files_.write("src/arms/left/meshes/100%.stl", "no code");
  EXPECT_EQ(resolver()("package://left_arm/meshes/100%.stl"), odd);
  EXPECT_NE(errorOf([&] { resolver()("package://left_arm/%2e%2e/package.xml"); }).find("leaves the package"),
            std::string::npos);
  EXPECT_NE(errorOf([&] { resolver()("package://left_arm/meshes/a.stl%00b"); }).find("%00"), std::string::npos);
}

TEST_F(Resolver, APackageThatIsNotFoundIsAnErrorWithTheFoldersThatWereSearched) {
  const MeshResolver resolve = packageResolver({files_.path("src"), files_.path("overlay")});
  EXPECT_EQ(errorOf([&] { resolve("package://absent/a.stl"); }),
            "package://absent/a.stl: no package named absent below the folders that are searched: " +
                files_.path("src") + ", " + files_.path("overlay"));
  EXPECT_NE(errorOf([] { packageResolver({})("package://absent/a.stl"); }).find("ROS_PACKAGE_PATH"), std::string::npos);
}

TEST_F(Resolver, AFileThatCannotBeReadIsAnErrorWithTheReason) {
  const auto expect = [&](const std::string& path, const std::string& reason) {
    EXPECT_EQ(errorOf([&] { resolver()(path); }), path + ": cannot be read (" + reason + ")");
  };
  expect(files_.path("absent.stl"), "No such file or directory");
  expect(files_.path("src"), "Is a directory");
  expect(files_.path("src/arms/left/meshes/a.stl/b.stl"), "Not a directory");
  std::filesystem::create_symlink(files_.path("loop.stl"), files_.path("loop.stl"));
  expect(files_.path("loop.stl"), "Too many levels of symbolic links");
}

TEST(RosPackagePath, HasTheFoldersOfTheVariableAndThoseOfDebian) {
  setenv("ROS_PACKAGE_PATH", "/one:/two::/three:/one", 1);
  EXPECT_EQ(rosPackagePath(), (std::vector<std::string>{"/one", "/two", "/three", "/usr/share"}));
  setenv("ROS_PACKAGE_PATH", "/usr/share:/one", 1);
  EXPECT_EQ(rosPackagePath(), (std::vector<std::string>{"/usr/share", "/one"}));
  unsetenv("ROS_PACKAGE_PATH");
  EXPECT_EQ(rosPackagePath(), (std::vector<std::string>{"/usr/share"}));
}

}  // namespace proximity_server::scene::mesh_test
