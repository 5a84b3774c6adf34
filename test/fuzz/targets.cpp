#include "fuzz/targets.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "fuzz/require.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/load_robot_model.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "proximity_server/scene/query/make_scene_model.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/files.h"
#include "tools/command_line/joint_states.h"

namespace proximity_server::fuzz {

using namespace narrowphase;
using namespace scene;
using namespace tools;
namespace {

std::string extensionFor(char letter) {
  if (letter == 's') return ".stl";
  if (letter == 'p') return ".ply";
  return letter == 'o' ? ".obj" : ".dae";
}

void checkMesh(const TriangleMesh& mesh) {
  require(!mesh.triangles.empty(), "a mesh has triangles");
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    require(vertex.cwiseAbs().maxCoeff() <= 1e6, "a coordinate is finite and at most 1e6 m");
  }
  const int vertices = static_cast<int>(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    for (const int corner : triangle) require(corner >= 0 && corner < vertices, "a corner is a vertex");
  }
}

void checkPieces(const TriangleMesh& mesh) {
  const MeshPieces pieces = convexPieces(mesh);
  require(!pieces.hulls.empty(), "a mesh becomes at least one piece");
  for (const ConvexHull& hull : pieces.hulls) {
    for (const Eigen::Vector3d& vertex : hull.vertices()) require(vertex.allFinite(), "a piece is finite");
  }
  require(pieces.deviation >= 0.0 && std::isfinite(pieces.deviation), "a deviation is finite");
}

void checkRobot(const RobotModel& model, const std::string& srdf) {
  const BodyPoses poses = forwardKinematics(model, std::vector<double>(model.joints.size(), 0.0));
  for (const auto& pose : poses) require(pose && pose->matrix().allFinite(), "a pose is finite");
  for (const Piece& piece : model.pieces) require(piece.body_T_piece.matrix().allFinite(), "a piece has a place");
  makeSceneModel(model, srdf);
}

const char* const kSlider =
    "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>"
    "<joint name='x' type='continuous'><parent link='a'/><child link='b'/></joint>"
    "<joint name='y' type='continuous'><parent link='b'/><child link='c'/><mimic joint='x'/></joint>"
    "<joint name='a long name' type='floating'><parent link='c'/><child link='d'/></joint></robot>";

}  // namespace

void tryMesh(const std::string& bytes) {
  // Decomposing more takes too long for one of millions of inputs.
  constexpr std::size_t kMaxDecomposed = 24;
  if (bytes.empty()) return;
  static const TemporaryFiles files;
  try {
    const TriangleMesh mesh = loadMesh(files.write("mesh" + extensionFor(bytes[0]), bytes.substr(1)), {1.0, 1.0, -1.0});
    checkMesh(mesh);
    if (mesh.triangles.size() <= kMaxDecomposed) checkPieces(mesh);
  } catch (const std::invalid_argument&) {
  }
}

void tryRobot(const std::string& bytes) {
  const std::string separator = "=== SRDF ===\n";
  const std::size_t end = bytes.find(separator);
  const std::string srdf = end == std::string::npos ? "" : bytes.substr(end + separator.size());
  ModelOptions options;
  options.allow_missing_meshes = true;
  try {
    checkRobot(loadRobotModel(bytes.substr(0, end), packageResolver({}), options), srdf);
  } catch (const std::invalid_argument&) {
  }
}

void tryStates(const std::string& bytes) {
  static const RobotModel robot = loadRobotModel(kSlider, packageResolver({}));
  std::istringstream stream(bytes);
  try {
    JointStates states(stream, "states.csv", robot);
    for (std::vector<double> positions; states.next(positions);) {
      require(positions.size() == robot.joints.size(), "a state has a position for each joint");
      for (const double position : positions) require(std::isfinite(position), "a position is finite");
    }
  } catch (const std::invalid_argument&) {
  }
}

}  // namespace proximity_server::fuzz
