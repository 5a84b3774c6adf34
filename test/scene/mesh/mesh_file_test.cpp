// Files that other programs read, too: they are taken as those programs take them.
#include "scene/mesh/mesh_file.h"

#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "proximity_server/scene/objects/object.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <cctype>

namespace proximity_server::scene::mesh_file_test {

const Eigen::Vector3d kUnscaled = Eigen::Vector3d::Ones();

/// A solid of two triangles without the line at its end, with a coordinate of 9 as a number with an exponent.
std::string solid(const std::string& name) {
  std::string text = "solid " + name + "\n";
  for (const char* z : {"0", "9.0e+00"}) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (const char* corner : {"0 0 ", "1 0 ", "0 1 "}) text += "vertex " + std::string(corner) + z + "\n";
    text += "endloop\nendfacet\n";
  }
  return text;
}

std::string inUpperCase(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  return text;
}

TEST(AsciiStl, KeywordsAndItsEndAreReadAsTheyAreWritten) {
  const struct {
    std::string text;
    std::size_t triangles;
  } cases[] = {
      {solid("a") + "endsolid a\n", 2},
      {solid("a") + "end solid a\n", 2},
      {solid("a") + "end solid a\n" + solid("b") + "end solid b\n", 4},
      {solid("a") + "endsolid a\n" + solid("b") + "endsolid b", 4},
      {solid("") + "endsolid\n", 2},
      {solid("a") + "endsolid a facet of a body\n", 2},
      {inUpperCase(solid("a") + "endsolid a\n"), 2},
      {inUpperCase(solid("a") + "end solid a\n" + solid("b") + "end solid b\n"), 4},
      {"Solid a\n" + solid("").substr(7) + "EndSolid a\n", 2},
      {"\xEF\xBB\xBF" + solid("a") + "endsolid a\n", 2},
  };
  const TemporaryFiles files;
  for (const auto& [text, triangles] : cases) {
    const TriangleMesh mesh = loadMesh(files.write("a.stl", text), kUnscaled);
    EXPECT_EQ(mesh.triangles.size(), triangles) << text;
    double highest = 0.0;
    for (const Eigen::Vector3d& vertex : mesh.vertices) highest = std::max(highest, vertex.z());
    EXPECT_EQ(highest, 9.0) << text;
  }
}

/// A triangle whose farthest corner is 2 units from the origin.
std::string collada(const std::string& asset) {
  return R"(<?xml version="1.0"?><COLLADA version="1.4.1"><asset>)" + asset +
         R"(</asset><library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="9">0 0 0 1 0 0
         0 2 0</float_array><technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
         <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
         <vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1">
         <input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
         <library_visual_scenes><visual_scene id="s"><node><scale>3 3 3</scale><instance_geometry url="#g"/></node>
         </visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

const std::string kInch = R"(<unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis>)";
const std::string kSentence =
    "a Collada file with a unit of 0.0254 m, so its lengths are multiplied by 0.0254, as in RViz; MoveIt takes them as "
    "metres. All agree if it is exported in metres.";

TEST(ColladaUnit, IsTheFactorOfTheLengths) {
  const TemporaryFiles files;
  const auto unitOf = [&](const std::string& asset) {
    const MeshWithUnit read = readMesh(files.write("a.dae", collada(asset)), kUnscaled);
    EXPECT_NEAR(read.mesh.vertices.at(2).y(), 6.0 * read.unit, 1e-6 * read.unit) << asset;
    return read.unit;
  };
  EXPECT_EQ(unitOf(""), 1.0);
  EXPECT_EQ(unitOf("<up_axis>X_UP</up_axis>"), 1.0);
  EXPECT_EQ(unitOf(R"(<unit name="meter" meter="1"/><up_axis>Y_UP</up_axis>)"), 1.0);
  EXPECT_NEAR(unitOf(kInch), 0.0254, 1e-8);
  EXPECT_EQ(readMesh(files.write("a.stl", solid("a") + "endsolid a\n"), kUnscaled).unit, 1.0);
}

TEST(ColladaUnit, IsNamedIfItIsNotTheMetre) {
  const TemporaryFiles files;
  const std::string inches = files.write("inches.dae", collada(kInch)), metres = files.write("a.dae", collada(""));
  const auto link = [](const std::string& name, const std::string& file) {
    return "<link name='" + name + "'><collision><geometry><mesh filename='" + file +
           "'/></geometry></collision></link>";
  };
  const auto joint = [](const std::string& child) {
    return "<joint name='to_" + child + "' type='fixed'><parent link='a'/><child link='" + child + "'/></joint>";
  };
  const std::string urdf = "<robot name='r'>" + link("a", metres) + link("b", inches) + link("c", inches) + joint("b") +
                           joint("c") + "</robot>";
  int named = 0;
  for (const std::string& warning : loadRobotModel(urdf, packageResolver({})).warnings)
    named += warning == "2 <collision> elements of the links \"b\", \"c\": " + kSentence;
  EXPECT_EQ(named, 1);

  ObjectOptions options;
  options.resolve = packageResolver({});
  const auto warnings = [&](const std::string& file) {
    return warningsOf(makeObject("box", {{MeshFile{file}}}, Fixed{}, options));
  };
  EXPECT_EQ(warnings(inches).at(0), "object \"box\": mesh " + inches + ": " + kSentence);
  for (const std::string& warning : warnings(metres)) EXPECT_EQ(warning.find("Collada"), std::string::npos) << warning;
}

}  // namespace proximity_server::scene::mesh_file_test
