// Answers of SceneBatch about the states that it reads from standard input, without Python: the tests compare them with
// those of the module, to the last bit.
//
// usage: python_batch_answers URDF SRDF PACKAGES DISTANCE K <states
//
// A state is a line of positions; a row is a line of the question, the state and the fields. Numbers have all of their
// bits.

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "scene/example_robots.h"

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace proximity_server::scene {
namespace {

std::vector<std::string> foldersOf(const std::string& path_list) {
  std::istringstream stream(path_list);
  std::vector<std::string> folders;
  for (std::string folder; std::getline(stream, folder, ':');) folders.push_back(folder);
  return folders;
}

std::shared_ptr<const SceneModel> load(char** arguments) {
  const MeshResolver resolve = packageResolver(foldersOf(arguments[3]));
  return std::make_shared<const SceneModel>(
      makeSceneModel(loadRobotModel(readFile(arguments[1]), resolve, cachedLoading()), readFile(arguments[2])));
}

Eigen::MatrixXd readStates(Eigen::Index joints) {
  std::vector<double> numbers;
  for (std::string word; std::cin >> word;) numbers.push_back(std::strtod(word.c_str(), nullptr));
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      numbers.data(), static_cast<Eigen::Index>(numbers.size()) / joints, joints);
}

void print(const char* question, Eigen::Index state, const SceneModel& model, const PairProximity& pair) {
  const narrowphase::SignedDistance& result = pair.result;
  std::printf("%s %d %d", question, static_cast<int>(state), static_cast<int>(result.status));
  if (result.status != narrowphase::Status::Unknown) {
    std::printf(" %s %s %d %d %d %a %a %a", model.robot.links[pair.asked.a.link()].name.c_str(),
                model.robot.links[pair.asked.b.link()].name.c_str(), result.unique ? 1 : 0,
                pair.depth_is_lower_bound ? 1 : 0, static_cast<int>(pair.representation), result.distance,
                result.lower_bound, result.upper_bound);
    for (const Eigen::Vector3d& vector : {result.point_a, result.point_b, result.normal})
      std::printf(" %a %a %a", vector.x(), vector.y(), vector.z());
  }
  std::puts("");
}

void print(const char* question, const SceneModel& model, const StatePairs& lists) {
  for (std::size_t i = 0; i < lists.unknown.size(); ++i) {
    if (lists.unknown[i]) print(question, static_cast<Eigen::Index>(i), model, {});
    for (std::size_t j = lists.begins[i]; j < lists.begins[i + 1]; ++j)
      print(question, static_cast<Eigen::Index>(i), model, lists.pairs[j]);
  }
}

void answer(char** arguments) {
  const std::shared_ptr<const SceneModel> model = load(arguments);
  const Eigen::MatrixXd states = readStates(static_cast<Eigen::Index>(model->robot.joints.size()));
  const double distance = std::atof(arguments[4]);
  SceneBatch batch(model);
  const std::vector<PairProximity>& minima = batch.minimum(states);
  for (std::size_t i = 0; i < minima.size(); ++i) print("minimum", static_cast<Eigen::Index>(i), *model, minima[i]);
  print("closest", *model, batch.closest(states, std::atoi(arguments[5])));
  print("pairs_below", *model, batch.below(states, distance));
  const std::vector<StateVerdict>& verdicts = batch.anyBelow(states, distance);
  for (std::size_t i = 0; i < verdicts.size(); ++i)
    std::printf("below %zu %d %d\n", i, static_cast<int>(verdicts[i].kind), verdicts[i].pair);
}

}  // namespace
}  // namespace proximity_server::scene

int main(int argc, char** argv) {
  if (argc != 6) {
    std::cerr << "usage: python_batch_answers URDF SRDF PACKAGES DISTANCE K <states\n";
    return 1;
  }
  proximity_server::scene::answer(argv);
}
