#include "fuzz/targets.h"

#include "fuzz/require.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/sensed/cloud_file.h"
#include "robots/robots.h"
#include "scene/files.h"
#include "tools/robot/object_schedule.h"
#include "tools/states/csv_states.h"
#include "tools/states/numpy_states.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>

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

RobotModel slider() { return loadRobotModel(robotText("slider.urdf"), packageResolver({})); }

void checkStates(StateSource&& states) {
  const StateHeader& header = states.header();
  std::uint64_t count = 0;
  for (TrajectoryPoint state; states.next(state); ++count) {
    require(state.positions.size() == header.robot.joints.size(), "a state has a position for each joint");
    for (const double position : state.positions) require(std::isfinite(position), "a position is finite");
    require(header.has(JointColumn::Quantity::Time) == std::isfinite(state.time), "a state has a time if all have");
  }
  require(states.count().value_or(count) == count, "there are as many states as the source says");
}

void checkObject(const ObjectEdit& object) {
  require(!object.shapes.empty() && !object.source.empty(), "an object has shapes and a place");
  require(object.padding >= 0.0 && std::isfinite(object.padding), "a padding is finite");
  require(object.place.pose.matrix().allFinite(), "a pose is finite");
  for (const ObjectShape& shape : object.shapes) {
    require(shape.object_T_shape.matrix().allFinite(), "a shape has a place");
    const auto* mesh = std::get_if<TriangleMesh>(&shape.geometry);
    for (std::size_t i = 0; mesh && i < mesh->triangles.size(); ++i)
      for (const int corner : mesh->triangles[i])
        require(corner >= 0 && corner < static_cast<int>(mesh->vertices.size()), "a corner is a vertex");
  }
}

/// Checks that a file is read as it was written.
void checkWriting(const ObjectFile& file) {
  const ObjectFile again = objectFileFrom(readYaml(yamlOf(file), "again"), "again");
  require(again.objects.size() == file.objects.size() && again.rules.size() == file.rules.size(), "nothing is lost");
  for (std::size_t i = 0; i < file.objects.size(); ++i) {
    require(again.objects[i].id == file.objects[i].id, "an id stays");
    require(again.objects[i].shapes.size() == file.objects[i].shapes.size(), "shapes stay");
    require(again.objects[i].place.link == file.objects[i].place.link, "a link stays");
  }
}

bool hasMeshes(const ObjectFile& file) {
  const auto has = [](const ObjectEdit& object) {
    return std::any_of(object.shapes.begin(), object.shapes.end(), [](const ObjectShape& shape) {
      return std::holds_alternative<TriangleMesh>(shape.geometry) || std::holds_alternative<MeshFile>(shape.geometry);
    });
  };
  return std::any_of(file.objects.begin(), file.objects.end(), has) ||
         std::any_of(file.changes.begin(), file.changes.end(),
                     [&](const WrittenChange& change) { return has(change.edit); });
}

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
  static const RobotModel robot = slider();
  static const TemporaryFiles files;
  std::istringstream stream(bytes);
  try {
    if (bytes.compare(0, 6, "\x93NUMPY") == 0) {
      checkStates(NumpyStates(files.write("states.npy", bytes), {"time", "x"}, robot));
    } else if (bytes.compare(0, 2, "PK") == 0) {
      checkStates(NumpyStates(files.write("states.npz", bytes), {}, robot));
    } else {
      checkStates(CsvStates(stream, "states.csv", robot));
    }
  } catch (const std::invalid_argument&) {
  }
}

void tryObjectFile(const std::string& bytes) {
  if (bytes.empty()) return;
  static const auto robot = std::make_shared<const SceneModel>(makeSceneModel(slider(), ""));
  const std::string text = bytes.substr(1);
  try {
    const ObjectFile file =
        bytes[0] == 's' ? readMoveitScene(text, "file") : objectFileFrom(readYaml(text, "file"), "file");
    for (const ObjectEdit& object : file.objects) checkObject(object);
    for (const WrittenChange& change : file.changes)
      if (!change.edit.shapes.empty()) checkObject(change.edit);
    if (bytes[0] != 's') checkWriting(file);  // an id in MoveIt's text may be of any bytes
    if (hasMeshes(file)) return;              // their decomposition takes too long for one of millions of inputs
    ObjectSchedule schedule(robot, file, {});
    for (long row = 0; row < 8; ++row) schedule.advance(row, 0.5 * static_cast<double>(row), {0.5, 0.5, 0.0});
  } catch (const std::invalid_argument& error) {
    require(std::string(error.what()).rfind("file", 0) == 0, "an error names the file");
  }
}

void tryCloudFile(const std::string& bytes) {
  static const TemporaryFiles files;
  static const std::map<char, std::string> names{{'p', "a.pcd"}, {'l', "a.ply"}, {'b', "a.bt"}, {'o', "a.ot"}};
  const auto name = names.find(bytes.empty() ? ' ' : bytes[0]);
  if (name == names.end()) return;
  const std::string path = files.write(name->second, bytes.substr(1));
  try {
    for (const Eigen::AlignedBox3d& box : readCloudBoxes(path, 0.02))
      require(box.min().allFinite() && box.max().allFinite() && (box.sizes().array() > 0.0).all(), "a box has a size");
  } catch (const std::invalid_argument& error) {
    require(std::string(error.what()).rfind(path, 0) == 0, "an error names the file");
  }
}

}  // namespace proximity_server::fuzz
