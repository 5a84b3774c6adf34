// Files from strangers: each is refused with an error that names what is wrong, in bounded memory and time.
#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "proximity_server/scene/model/robot_model.h"
#include "sanitized.h"
#include "scene/files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cstdint>
#include <functional>

namespace proximity_server::scene::bad_input_test {

using namespace narrowphase;

void expectSays(const std::string& said, const std::string& what) {
  EXPECT_NE(said.find(what), std::string::npos) << "\"" << said.substr(0, 300) << "\" does not mention " << what;
  EXPECT_LT(said.size(), 3000U);
}

std::string repeated(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

/// "text0text1text2...", with the number for each '#'.
std::string numbered(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) {
    for (const char letter : text) result += letter == '#' ? std::to_string(i) : std::string(1, letter);
  }
  return result;
}

/// [s] of the processor that this process and its ended children have taken.
double processorSeconds() {
  double seconds = 0.0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const timeval& part : {usage.ru_utime, usage.ru_stime})
      seconds += static_cast<double>(part.tv_sec) + 1e-6 * static_cast<double>(part.tv_usec);
  }
  return seconds;
}

/// Returns the text of std::invalid_argument, and expects that it takes at most the minute of a processor that a file
/// may take to be read. A busy machine does not count.
template <typename Call>
std::string errorWithinAMinute(const Call& call) {
  const double begin = processorSeconds();
  std::string said = errorOf(call);
  EXPECT_LT(processorSeconds() - begin, 70.0) << said;
  return said;
}

/// [kB] the most memory that this process, or its largest child, ever had.
long maxMemory(decltype(RUSAGE_SELF) who) {
  rusage usage{};
  getrusage(who, &usage);
  return usage.ru_maxrss;
}

// A sanitizer ends a child whose memory runs out, with an exit code of its own.
#ifdef PROXIMITY_SANITIZED
const std::string kTooMuch = "it ";
#else
const std::string kTooMuch = "it takes ";  // memory, or time where the machine is busy
#endif

/// No test takes more than 1 GB here, beyond what the files before it took, nor 1.25 GB more than that in a child.
class BadInput : public ::testing::Test {
 protected:
  ~BadInput() override {
    EXPECT_LT(maxMemory(RUSAGE_SELF), 1L << 20);
    EXPECT_LT(maxMemory(RUSAGE_CHILDREN), maxMemory(RUSAGE_SELF) + (5L << 18));
  }

  std::string errorOfMesh(const std::string& name, const std::string& content) {
    return errorWithinAMinute([&] { loadMesh(files_.write(name, content), {1.0, 1.0, 1.0}); });
  }
  static std::string errorOfUrdf(const std::string& urdf) {
    return errorWithinAMinute([&] { loadRobotModel(urdf, packageResolver({})); });
  }
  static std::string errorOfSrdf(const std::string& srdf, const std::string& group = "") {
    const RobotModel model = loadRobotModel("<robot name='r'><link name='base'/></robot>", packageResolver({}));
    PairFilterOptions options;
    options.group = group;
    return errorWithinAMinute([&] { filterPairs(model, srdf, options); });
  }
  TemporaryFiles files_;
};

// --- meshes

using Mesh = BadInput;

struct BrokenFile {
  const char* name;
  std::string content, says;  ///< "": what assimp says may change
};

std::string binaryStl(std::uint32_t declared, std::size_t facets) {
  std::string bytes(80, ' ');
  bytes.append(reinterpret_cast<const char*>(&declared), sizeof declared);
  return bytes + std::string(50 * facets, '\0');
}

const std::string kFacet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

const std::string kFacetAt = "facet normal 0 0 1 outer loop vertex # 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n";

std::string withCoordinate(const std::string& coordinate) {
  std::string facet = kFacetAt;
  return "solid a\n" + facet.replace(facet.find('#'), 1, coordinate) + "endsolid a\n";
}

TEST_F(Mesh, BrokenStlSaysWhatIsWrong) {
  const BrokenFile files[] = {
      {"bomb.stl", binaryStl(1000000000U, 2), "declares 1000000000 triangles, but only 2 are there"},
      // 50 times as many, and 84, is in 32 bits the size of the file.
      {"wraps.stl", binaryStl(85899346U, 2), "declares 85899346 triangles, but only 2 are there"},
      {"short.stl", std::string(83, ' '), "shorter than the header"},
      {"empty.stl", "", "shorter than the header"},
      {"none.stl", binaryStl(0, 0), ""},
      {"none_ascii.stl", "solid a\nendsolid a\n", ""},
      {"between.stl", "solid a\n" + kFacet, "it is cut off"},
      {"within.stl", "solid a\n" + kFacet + kFacet.substr(0, 60), "it is cut off"},
      {"second.stl", "solid a\n" + kFacet + "endsolid a\nsolid b\n" + kFacet, "it is cut off"},
      {"upper.stl", "SOLID A\n", "it is cut off"},
      {"more.stl", binaryStl(1, 4), "declares 1 triangles, which end at byte 134, but it has 284 bytes"},
      {"solid.stl", "solid" + binaryStl(2, 2).substr(5) + "\n",
       "declares 2 triangles, which end at byte 184, but it has 185 bytes"},
      {"nan.stl", withCoordinate("nan"), "not finite"},
      {"infinite.stl", withCoordinate("1e300"), "not finite"},
      {"far.stl", withCoordinate("1e7"), "farther than 1e6 m"},
  };
  for (const BrokenFile& file : files) {
    const std::string said = errorOfMesh(file.name, file.content);
    expectSays(said, file.name);
    expectSays(said, file.says);
  }
}

TEST_F(Mesh, BrokenObjNamesTheFile) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const BrokenFile files[] = {
      {"beyond.obj", corners + "f 1 2 4\n", "vertex index out of range"},
      {"zero.obj", corners + "f 0 1 2\n", ""},
      {"before.obj", corners + "f -1 -2 -4\n", ""},
      {"huge.obj", corners + "f 1 2 99999999999999999999999\n", ""},
      {"letters.obj", corners + "f a b c\n", ""},
      {"short.obj", "v 0 0\n", ""},
      {"infinite.obj", "v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"},
      {"far.obj", "v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"},
      {"points.obj", corners, "no triangle"},
      {"word.obj", "v " + std::string(10000000, '9') + "\n", "no triangle"},
  };
  for (const BrokenFile& file : files) {
    const std::string said = errorOfMesh(file.name, file.content);
    expectSays(said, file.name);
    expectSays(said, file.says);
  }
}

// Assimp takes the cube of the corners: hours.
TEST_F(Mesh, PolygonOfCountlessCornersEnds) {
  expectSays(errorOfMesh("polygon.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + repeated(" 1 2 3", 100000) + "\n"),
             "polygon.obj: it takes ");
}

// Opening it would wait for ever.
TEST_F(Mesh, OtherFilesThatItNamesAreNotOpened) {
  ASSERT_EQ(mkfifo(files_.path("pipe.mtl").c_str(), 0600), 0);
  EXPECT_EQ(errorOfMesh("a.obj", "mtllib pipe.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"), "");
}

TEST_F(Mesh, HugeFilesAreNotRead) {
  const std::string path = files_.write("huge.stl", "solid");
  std::filesystem::resize_file(path, std::uintmax_t{1} << 40);  // sparse: takes no place on the disk
  const std::string said = errorWithinAMinute([&] { loadMesh(path, {1.0, 1.0, 1.0}); });
  expectSays(said, "huge.stl");
  expectSays(said, "more than 256 MiB");
}

TEST_F(Mesh, MoreThan200000TrianglesAreRefused) {
  expectSays(errorOfMesh("many.stl", binaryStl(200001, 200001)), "it has 200001 triangles, more than 200000");
  expectSays(errorOfMesh("many.obj", "v 0 0 0\n" + repeated("f 1 1 1\n", 200001)),
             "it has 200001 triangles, more than 200000");
}

TEST_F(Mesh, OtherFormatsAreNotGuessed) {
  expectSays(errorOfMesh("scene.blend", "BLENDER"), "only .stl, .dae, .obj and .ply");
}

/// A Collada file of the triangle (0, 0, 0), (1, 0, 0), (0, 1, 0) in pieces that may be wrong.
struct ColladaText {
  std::string head, floats = "9", triangles = "1", indices = "0 1 2";
  std::string node = "<node><instance_geometry url='#g'/></node>", library;
  std::string text() const {
    return "<?xml version='1.0'?>" + head +
           "<COLLADA version='1.4.1'><library_geometries><geometry id='g'><mesh><source id='p'><float_array id='a' "
           "count='" +
           floats +
           "'>0 0 0 1 0 0 0 1 0</float_array><technique_common><accessor source='#a' count='3' stride='3'>"
           "<param name='X' type='float'/><param name='Y' type='float'/><param name='Z' type='float'/></accessor>"
           "</technique_common></source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices>"
           "<triangles count='" +
           triangles + "'><input semantic='VERTEX' source='#v' offset='0'/><p>" + indices +
           "</p></triangles></mesh></geometry></library_geometries><library_nodes>" + library +
           "</library_nodes><library_visual_scenes><visual_scene id='s'>" + node +
           "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>";
  }
};

std::string withIndices(const std::string& indices) {
  ColladaText collada;
  collada.indices = indices;
  return collada.text();
}

std::string withNodes(const std::string& node, const std::string& library = "") {
  ColladaText collada;
  collada.node = node;
  collada.library = library;
  return collada.text();
}

TEST_F(Mesh, BrokenColladaNamesTheFile) {
  ASSERT_EQ(errorOfMesh("whole.dae", ColladaText().text()), "");
  const BrokenFile files[] = {
      {"beyond.dae", withIndices("0 1 3"), "Invalid data index (3/3)"},
      {"within.dae", withIndices("0 1"), ""},
      {"absent.dae", withNodes("<node><instance_geometry url='#x'/></node>"), "no triangle"},
      {"remote.dae", withNodes("<node><instance_geometry url='http://x/y#g'/></node>"), ""},
      {"far.dae", withNodes("<node><scale>1e300 1 1</scale><instance_geometry url='#g'/></node>"), "not finite"},
      {"nan.dae", withNodes("<node><translate>nan 0 0</translate><instance_geometry url='#g'/></node>"), "not finite"},
      {"matrix.dae", withNodes("<node><matrix>1 0 0</matrix></node>"), ""},
  };
  for (const BrokenFile& file : files) {
    const std::string said = errorOfMesh(file.name, file.content);
    expectSays(said, file.name);
    expectSays(said, file.says);
  }
  const std::string cut = errorOfMesh("cut.dae", ColladaText().text().substr(0, 300));
  const bool is_of_assimp_5_0 = cut.find("File came out empty") != std::string::npos;
  expectSays(cut, "cut.dae");
  if (!is_of_assimp_5_0) expectSays(cut, "XML");
}

// Each of these takes assimp all the memory there is, or all the stack.
TEST_F(Mesh, ColladaBombsAreDefused) {
  // The letter is never passed: an index more and more.
  expectSays(errorOfMesh("letter.dae", withIndices("0 1 x")), "letter.dae: " + kTooMuch);

  ColladaText floats, triangles;
  floats.floats = triangles.triangles = "1000000000";
  expectSays(errorOfMesh("floats.dae", floats.text()), "floats.dae: " + kTooMuch);
  expectSays(errorOfMesh("triangles.dae", triangles.text()), "triangles.dae: " + kTooMuch);

  // n40 twice in n39, that twice in n38, ...: 2^40 triangles.
  std::string doubling = "<node id='n40'><instance_geometry url='#g'/></node>";
  for (int i = 0; i < 40; ++i) {
    const std::string next = "<instance_node url='#n" + std::to_string(i + 1) + "'/>";
    doubling += "<node id='n" + std::to_string(i) + "'>" + next + next + "</node>";
  }
  expectSays(errorOfMesh("doubling.dae", withNodes("<node><instance_node url='#n0'/></node>", doubling)),
             "doubling.dae: " + kTooMuch);

  const std::string self = "<node id='n'><instance_node url='#n'/></node>";
  expectSays(errorOfMesh("self.dae", withNodes("<node><instance_node url='#n'/></node>", self)),
             "self.dae: it crashes: Segmentation fault");
  expectSays(errorOfMesh("deep.dae", withNodes(repeated("<node>", 100000) + repeated("</node>", 100000))),
             "deep.dae: it crashes: Segmentation fault");
}

// They stay what they are: text, 8^9 times as short as what it stands for. Nothing is fetched.
TEST_F(Mesh, EntitiesAreNotExpanded) {
  ColladaText laughs;
  laughs.head = "<!DOCTYPE c [<!ENTITY lol0 '2'>" +
                numbered("<!ENTITY lol1# '&lol#;&lol#;&lol#;&lol#;&lol#;&lol#;&lol#;&lol#;'>", 9) +
                "<!ENTITY file SYSTEM 'file:///etc/passwd'>]>";
  laughs.node = "<node name='&lol18;'><instance_geometry url='#g'/></node><node name='&file;'/>";
  EXPECT_EQ(errorOfMesh("laughs.dae", laughs.text()), "");
}

// --- robots

using Robot = BadInput;

std::string robot(const std::string& body) { return "<robot name='r'>" + body + "</robot>"; }

std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                  const std::string& body = "", const std::string& type = "continuous") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/>" +
         body + "</joint>";
}

TEST_F(Robot, XmlBombsAreDefused) {
  const std::string laughs = "<!DOCTYPE r [<!ENTITY a 'ha'>" + numbered("<!ENTITY b# '&a;&a;&a;&a;'>", 9) + "]>";
  // Not expanded: the name is the reference itself.
  EXPECT_EQ(loadRobotModel(laughs + robot("<link name='&b8;'/>"), packageResolver({})).links.at(0).name, "&b8;");
  expectSays(errorOfUrdf(repeated("<robot>", 100000)), "URDF");
  expectSays(errorOfUrdf(robot(repeated("<link name='a'>", 100000))), "URDF");
  expectSays(errorOfUrdf(robot("<link name='" + std::string(10000000, 'x') + "'/>")), "longer than 1024 characters");
  expectSays(errorOfUrdf(robot("<" + std::string(10000000, 'x') + "/>")), "longer than 1024 characters");
  expectSays(errorOfUrdf(robot(repeated("<a/>", 2000000))), "more than a million elements");
  expectSays(errorOfUrdf(robot(numbered("<link name='l#'/>", 400000))), "400000 links, more than 2000");
  expectSays(errorOfUrdf(robot("<link name='a'/>" + repeated(joint("j", "a", "a"), 100000))), "100000 joints");

  expectSays(errorOfSrdf(repeated("<robot>", 100000)), "SRDF");
  expectSays(errorOfSrdf(robot("<group name='" + std::string(10000000, 'x') + "'/>")), "SRDF: line 1");
  expectSays(errorOfSrdf(robot(repeated("<a/>", 2000000))), "SRDF: it has more than a million elements");
  expectSays(errorOfSrdf(robot(numbered("<group name='g#'/>", 2000))), "SRDF: it has 2000 groups");
}

// XML wants the declaration first. urdfdom reads it behind a comment, too, where a licence often pushes it.
TEST_F(Robot, ADeclarationMayFollowAComment) {
  const std::string head = "<!-- licence -->\n<?xml version='1.0'?>\n<?xml-model href='a'?>\n";
  EXPECT_EQ(loadRobotModel(head + robot("<link name='a'/>"), packageResolver({})).links.at(0).name, "a");
  EXPECT_EQ(errorOfSrdf(head + robot("<group name='g'/>"), "g"), "");
  expectSays(errorOfUrdf(head + robot("<link/>")), "line 4");
  expectSays(errorOfUrdf("<!-- licence --><?xml version='1.0'" + robot("<link name='a'/>")), "URDF");
}

TEST_F(Robot, GroupsOfGroupsAreAddedOnce) {
  std::string groups = "<group name='g40'/>";
  for (int i = 0; i < 40; ++i) {
    const std::string next = "<group name='g" + std::to_string(i + 1) + "'/>";
    groups += "<group name='g" + std::to_string(i) + "'>" + next + next + "</group>";
  }
  EXPECT_EQ(errorOfSrdf(robot(groups), "g0"), "");
}

TEST_F(Robot, UnknownLinksAreSuggestedForAFewOnly) {
  EXPECT_EQ(
      errorOfSrdf(robot(numbered("<disable_collisions link1='some_long_name_#' link2='other_long_name_#'/>", 100000))),
      "");
}

TEST_F(Robot, BrokenTreesNameTheLink) {
  const std::string three = "<link name='a'/><link name='b'/><link name='c'/>";
  expectSays(errorOfUrdf(robot(three + joint("j", "a", "b"))), "[");  // two roots, by urdfdom: [a] and [c]
  expectSays(errorOfUrdf(robot(three + joint("j", "a", "b") + joint("k", "b", "c") + joint("l", "c", "a"))), "loop");
  expectSays(errorOfUrdf(robot(three + joint("j", "a", "a") + joint("k", "a", "b"))), "loop");
  expectSays(errorOfUrdf(robot(three + joint("j", "b", "c") + joint("k", "c", "b"))), "loop");
}

TEST_F(Robot, NumbersBeyondAllMeasureNameTheThing) {
  const auto link = [](const std::string& shape, const std::string& origin) {
    return robot("<link name='arm'><collision><origin " + origin + "/><geometry>" + shape +
                 "</geometry></collision></link>");
  };
  const std::string here = "xyz='0 0 0'", box = "<box size='1 1 1'/>";
  for (const std::string& urdf : {link("<box size='1e300 1 1'/>", here), link("<sphere radius='1e300'/>", here),
                                  link("<cylinder radius='1' length='1e300'/>", here), link(box, "xyz='1e300 0 0'"),
                                  link(box, "xyz='nan 0 0'"), link(box, "xyz='inf 0 0'"), link(box, "rpy='nan 0 0'")}) {
    expectSays(errorOfUrdf(urdf), "arm");
  }
  const std::string geometry = "<collision><geometry><sphere radius='1'/></geometry></collision>";
  const std::string two = "<link name='a'/><link name='b'>" + geometry + "</link>";
  for (const std::string body : {"<origin xyz='1e300 0 0'/>", "<origin xyz='nan 0 0'/>", "<origin rpy='inf 0 0'/>",
                                 "<axis xyz='nan 0 0'/>", "<limit lower='nan' upper='1' effort='1' velocity='1'/>",
                                 "<limit lower='0' upper='inf' effort='1' velocity='1'/>", "<mimic joint='elbow'/>",
                                 "<mimic joint='elbow' multiplier='nan'/>"}) {
    expectSays(errorOfUrdf(robot(two + joint("elbow", "a", "b", body))), "elbow");
    if (body.find("origin") != std::string::npos)
      expectSays(errorOfUrdf(robot(two + joint("elbow", "a", "b", body, "fixed"))), "elbow");
  }
  expectSays(errorOfUrdf(robot(two + "<link name='c'>" + geometry + "</link>" + joint("j", "a", "b") +
                               joint("elbow", "b", "c", "<mimic joint='j' multiplier='1e300'/>"))),
             "elbow");
}

// Regression: urdfdom takes what it says of these as a format of printf, which ended the process.
TEST_F(Robot, NumbersThatAreFormatsNameTheThing) {
  const std::string box = "<box size='1 1 1'/>";
  for (const auto& [shape, origin] : {std::pair<std::string, std::string>{box, "xyz='0%n 0 0'"},
                                      {box, "rpy='0 %n 0'"},
                                      {"<box size='1 1 %n'/>", ""},
                                      {"<sphere radius='%n'/>", ""},
                                      {"<cylinder radius='%n' length='1'/>", ""},
                                      {"<cylinder radius='1' length='%s%n'/>", ""},
                                      {"<mesh filename='a.obj' scale='1 1 %n'/>", ""}}) {
    const std::string said = errorOfUrdf(robot("<link name='arm'><collision><origin " + origin + "/><geometry>" +
                                               shape + "</geometry></collision></link>"));
    expectSays(said, "link \"arm\"");
    expectSays(said, "%n");
  }
  const std::string two = "<link name='a'/><link name='b'/>";
  for (const std::string body :
       {"<origin xyz='%n 0 0'/>", "<axis xyz='0 0 %n'/>", "<limit lower='%n' upper='1' effort='1' velocity='1'/>"}) {
    expectSays(errorOfUrdf(robot(two + joint("elbow", "a", "b", body))), "joint \"elbow\"");
  }
  const RobotModel model = loadRobotModel(robot("<link name='50%n'/>"), packageResolver({}));
  EXPECT_EQ(model.links.at(0).name, "50%n");
}

TEST_F(Robot, LimitsBeyondAllMeasureAreNone) {
  const RobotModel model = loadRobotModel(
      robot("<link name='a'/><link name='b'/>" +
            joint("slide", "a", "b", "<limit lower='0' upper='1e300' effort='1' velocity='1'/>", "prismatic")),
      packageResolver({}));
  EXPECT_EQ(model.joints.at(0).lower, 0.0);
  EXPECT_EQ(model.joints.at(0).upper, std::numeric_limits<double>::infinity());
  ASSERT_FALSE(model.warnings.empty());
  expectSays(model.warnings.front(), "slide");
}

// --- where meshes may lie

class MeshUri : public BadInput {
 protected:
  MeshUri() {
    files_.write("ws/arm/package.xml", "<package><name>arm</name></package>");
    files_.write("ws/arm/meshes/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    files_.write("secret.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    files_.link("secret.obj", "ws/arm/meshes/link.obj");
  }
  std::string errorOfLink(const std::string& uri, const std::vector<std::string>& allowed = {}) {
    return errorOf([&] {
      loadRobotModel(
          robot("<link name='hand'><collision><geometry><mesh filename='" + uri + "'/></geometry></collision></link>"),
          withinRoots(packageResolver({files_.path("ws")}), allowed));
    });
  }
};

TEST_F(MeshUri, OtherSchemesAreRefusedNamingLinkAndUri) {
  for (const std::string uri : {"http://host/a.stl", "https://host/a.stl", "ftp://host/a.stl", "model://arm/a.stl",
                                "FILE:///a.stl", "file://host/a.stl", "data:text/plain,a", "://"}) {
    const std::string said = errorOfLink(uri);
    expectSays(said, "\"hand\"");
    expectSays(said, uri);
  }
}

TEST_F(MeshUri, PathsOutOfAPackageAreRefused) {
  EXPECT_EQ(errorOfLink("package://arm/meshes/../meshes/a.obj"), "");
  for (const std::string uri : {"package://arm/../../secret.obj", "package://arm/meshes/../../../secret.obj",
                                "package://arm//../../secret.obj"}) {
    expectSays(errorOfLink(uri), uri + ": leaves the package arm");
  }
}

TEST_F(MeshUri, AllowedRootsHoldForEveryKindOfPath) {
  const std::string workspace = files_.path("ws"), outside = files_.path("secret.obj");
  EXPECT_EQ(errorOfLink("package://arm/meshes/a.obj", {workspace}), "");
  EXPECT_EQ(errorOfLink("file://" + outside, {workspace, files_.path("")}), "");
  EXPECT_EQ(errorOfLink(outside), "");
  for (const std::string& uri :
       {outside, "file://" + outside, workspace + "/../secret.obj", std::string("package://arm/meshes/link.obj")}) {
    const std::string said = errorOfLink(uri, {workspace});
    expectSays(said, "\"hand\"");
    expectSays(said, uri);
    expectSays(said, "below no allowed mesh root");
  }
  // A folder whose name only begins like that of a root.
  files_.write("ws2/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expectSays(errorOfLink(files_.path("ws2/a.obj"), {workspace}), "below no allowed mesh root");
  expectSays(errorOf([&] { withinRoots(packageResolver({}), {"/absent/root"}); }), "/absent/root");
}

}  // namespace proximity_server::scene::bad_input_test
