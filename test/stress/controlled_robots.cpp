#include "stress/controlled_robots.h"

#include <utility>

#include "proximity_server/scene/loading/load_robot_model.h"
#include "scene/example_robots.h"
#include "scene/random_objects.h"

namespace proximity_server::scene {
namespace {

std::shared_ptr<const SceneModel> modelOf(const std::string& urdf, const std::string& srdf,
                                          const MeshResolver& resolve) {
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobotModel(readFile(urdf), resolve, quickLoading());
  model->pairs = filterPairs(model->robot, readFile(srdf));
  return model;
}

std::vector<ControlFamily> allFamilies() {
  std::vector<ControlFamily> families{{"random robot", 1, false, nullptr}, {"random robot, objects", 1, true, nullptr}};
  const std::string demo = PROXIMITY_SOURCE_DIR "/config/demo/robot";
  families.push_back({"demo, objects", 4, true,
                      modelOf(demo + ".urdf", demo + ".srdf", packageResolver({PROXIMITY_SOURCE_DIR "/.."}))});
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) return families;
  for (const ExampleRobot& robot : robotsToTest()) {
    const auto model = modelOf(exampleRobotFile(resolve, robot.urdf), exampleRobotFile(resolve, robot.srdf), resolve);
    const int rarity = robot.name == std::string("Pr2") ? 16 : 4;
    families.push_back({robot.name, rarity, false, model});
    families.push_back({robot.name + std::string(", objects"), rarity, true, model});
  }
  return families;
}

}  // namespace

const std::vector<ControlFamily>& controlFamilies() {
  static const std::vector<ControlFamily> families = allFamilies();
  return families;
}

Chance chanceOf(unsigned seed, std::size_t family, std::int64_t number) {
  std::seed_seq mixed{seed, static_cast<unsigned>(family), static_cast<unsigned>(number),
                      static_cast<unsigned>(number >> 32)};
  unsigned one = 0;
  mixed.generate(&one, &one + 1);
  return Chance(one);
}

std::shared_ptr<const Objects> someObjects(const std::shared_ptr<const SceneModel>& model, Chance& chance) {
  const auto linkName = [&] {
    return model->robot.links[chance.below(static_cast<int>(model->robot.links.size()))].name;
  };
  std::vector<ObjectChange> changes;
  for (int i = 0; i < 4; ++i)
    changes.push_back(AddObject{someObject("fixed " + std::to_string(i), Fixed{chance.pose(0.8)}, chance)});
  changes.push_back(AddObject{someObject("moving", Moving{"cart", chance.pose(0.3)}, chance)});
  for (int i = 0; i < 2; ++i)
    changes.push_back(AddObject{
        someObject("held " + std::to_string(i), Attached{linkName(), {linkName()}, chance.pose(0.1)}, chance)});
  return std::make_shared<const Objects>(Objects(model).changed(changes));
}

FramePoses someFrames(const Objects& objects, Chance& chance) {
  FramePoses frames;
  for (std::size_t i = 0; i < objects.frames().size(); ++i) frames.emplace_back(chance.pose(0.5));
  return frames;
}

}  // namespace proximity_server::scene
