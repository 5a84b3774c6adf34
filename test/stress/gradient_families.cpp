#include "oracle/shape_pairs.h"
#include "peers/robots.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/joined_robots.h"
#include "robots/robots.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "stress/gradient_checks.h"

#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::NamedShape;

std::shared_ptr<const SceneModel> sceneModelOf(RobotModel robot, const std::string& srdf = "") {
  return std::make_shared<const SceneModel>(makeSceneModel(std::move(robot), srdf));
}

Object attached(const std::string& id, const narrowphase::Shape& shape, const std::string& link,
                const Isometry3d& link_T_object) {
  return makeObject(id, {{shape}}, Attached{link, {}, link_T_object});
}

const Isometry3d& inLeft() {
  static const Isometry3d pose = turned(0.4, {1.0, 0.3, -0.2}, {0.1, -0.2, 0.15});
  return pose;
}
const Isometry3d& inRight() {
  static const Isometry3d pose = turned(-0.9, {0.1, 0.7, 0.2}, {-0.1, 0.1, 0.2});
  return pose;
}

/// The floating joint puts b where the distance may be anything from a deep overlap to 1 m.
GradientSample drawPairOfShapes(const SceneModel& model, const ShapeRefPair& pair, Chance& chance) {
  const RobotModel& robot = model.robot;
  Posture posture = Posture::random(robot, chance);
  const BodyPoses poses = posture.poses();
  const Joint& floating = robot.joints.back();
  const Isometry3d joint_pose = *poses[bodyOf(robot, "r1")] * floating.parent_T_joint;
  const Isometry3d pose_a = *poses[bodyOf(robot, "left")] * inLeft();
  const Isometry3d pose_b = pose_a * chance.pose(chance.between(0.1, 0.7));
  posture.setMotion(static_cast<int>(robot.joints.size()) - 1,
                    joint_pose.inverse(Eigen::Isometry) * pose_b * inRight().inverse(Eigen::Isometry));
  return {posture, pair};
}

GradientFamily pairOfShapes(const std::shared_ptr<const SceneModel>& model, const NamedShape& a, const NamedShape& b) {
  const auto objects = std::make_shared<const Objects>(Objects(model).changed(
      {AddObject{attached("a", a.shape, "left", inLeft())}, AddObject{attached("b", b.shape, "right", inRight())}}));
  const ShapeRefPair pair{ShapeRef::ofObject(objects->find("a")), ShapeRef::ofObject(objects->find("b"))};
  return {a.name + ", " + b.name, model, objects,
          [model, pair](PosedScene&, Chance& chance) { return drawPairOfShapes(*model, pair, chance); }, true};
}

/// Any two links with geometry that a joint moves against each other, or the two that are closest.
ShapeRefPair drawPairOfLinks(PosedScene& scene, Chance& chance) {
  if (chance.below(2) == 0)
    if (const PairProximity* closest = scene.minimum({scene.candidates(), PairKind::OfLinks})) return closest->asked;
  return scene.candidates()[chance.below(static_cast<int>(scene.candidates().size()))];
}

GradientFamily robotByItself(const std::string& name, const std::shared_ptr<const SceneModel>& model) {
  return {name, model, nullptr, [](PosedScene& scene, Chance& chance) {
            Posture posture = Posture::random(scene.model().robot, chance);
            scene.update(posture.poses());
            return GradientSample{posture, drawPairOfLinks(scene, chance)};
          }};
}

GradientFamily twoRobots(const std::string& name, const RobotModel& one, double apart) {
  const auto model = std::make_shared<const SceneModel>(
      makeSceneModel(joined({{"left", one}, {"right", one}}), std::vector<std::string>(2)));
  return {name, model, nullptr, [apart](PosedScene& scene, Chance& chance) {
            const RobotModel& robot = scene.model().robot;
            Posture posture = Posture::random(robot, chance);
            posture.placeRoot(1, turned(3.0, {0.1, 0.0, 1.0}, {apart, 0.1, 0.0}));
            scene.update(posture.poses());
            ShapeRefPair pair;
            do pair = drawPairOfLinks(scene, chance);
            while (&robot.robotOf(pair.a.link()) == &robot.robotOf(pair.b.link()) && chance.below(20) > 0);
            return GradientSample{posture, pair};
          }};
}

/// Objects of every shape around a robot, and two in the hand.
std::shared_ptr<const Objects> objectsAround(const std::shared_ptr<const SceneModel>& model, const std::string& hand) {
  using narrowphase::Box;
  using narrowphase::Cylinder;
  using narrowphase::Sphere;
  std::vector<ObjectChange> changes{
      AddObject{attached("held box", Box{{0.1, 0.06, 0.2}}, hand, turned(0.7, {1, 1, 0}, {0.02, 0.0, 0.12}))},
      AddObject{attached("held can", Cylinder{0.04, 0.15}, hand, turned(0.2, {1, 0, 0}, {0.05, 0.1, 0.1}))},
      AddObject{makeObject("floor", {{HalfSpace{{0.1, 0.0, 1.0}, -0.1}}}, Fixed{})},
      AddObject{makeObject("two boxes", {{Box{{0.3, 0.2, 0.1}}}, {Sphere{0.1}, narrowphase::at(0.3, 0.0, 0.1)}},
                           Fixed{turned(0.4, {0, 1, 1}, {0.6, 0.2, 0.5})})}};
  Chance chance(5);
  for (const NamedShape& solid : narrowphase::solidShapes())
    changes.push_back(AddObject{makeObject(solid.name, {{solid.shape}}, Fixed{chance.pose(1.2)})});
  return std::make_shared<const Objects>(Objects(model).changed(changes));
}

GradientFamily robotWithObjects(const std::string& name, const std::shared_ptr<const SceneModel>& model,
                                const std::string& hand) {
  const auto objects = objectsAround(model, hand);
  return {name, model, objects, [objects](PosedScene& scene, Chance& chance) {
            Posture posture = Posture::random(scene.model().robot, chance);
            scene.update(posture.poses());
            const PairProximity* closest =
                chance.below(2) == 0 ? scene.minimum({scene.candidates(), PairKind::WithObject}) : nullptr;
            if (closest) return GradientSample{posture, closest->asked};
            const ShapeRef object = ShapeRef::ofObject(chance.below(objects->size()));
            const ShapeRefPair links = drawPairOfLinks(scene, chance);
            return GradientSample{posture,
                                  chance.below(2) == 0 ? ShapeRefPair{object, links.a} : ShapeRefPair{links.b, object}};
          }};
}

}  // namespace

std::vector<GradientFamily> pairsOfShapes() {
  std::vector<GradientFamily> families;
  const auto model = sceneModelOf(robotOf(robotText("branches.urdf")));
  const std::vector<NamedShape> shapes = narrowphase::allShapes();
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = i; j < shapes.size(); ++j) families.push_back(pairOfShapes(model, shapes[i], shapes[j]));
  return families;
}

std::vector<GradientFamily> demoRobots() {
  const auto demo = peers::demoRobot().model;
  return {robotByItself("demo robot", demo), twoRobots("two demo robots", demo->robot, 0.7),
          robotWithObjects("demo robot with objects", demo, "left_hand")};
}

std::vector<GradientFamily> exampleRobots() {
  std::vector<GradientFamily> families;
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) return families;
  for (const ExampleRobot& robot : robotsToTest()) {
    const auto model =
        sceneModelOf(loadRobotModel(readFile(exampleRobotFile(resolve, robot.urdf)), resolve, quickLoading()),
                     readFile(exampleRobotFile(resolve, robot.srdf)));
    families.push_back(robotByItself(robot.name, model));
    if (families.size() > 1) continue;  // the first one is Panda
    families.push_back(robotWithObjects("Panda with objects", model, "panda_hand"));
    families.push_back(twoRobots("two Pandas", model->robot, 0.8));
  }
  return families;
}

}  // namespace proximity_server::scene
