#include "node/answers/sensed_message.h"

#include "node/answers/conversions.h"

namespace proximity_server::node {
namespace {

/// The closest pair with an object; nullptr if none is checked or near.
const scene::PairProximity* closestTo(int number, const Robot& robot, PosedScenes& scenes) {
  const scene::ShapeRef object = scene::ShapeRef::ofObject(number);
  const scene::Objects& objects = *scenes.state.objects();
  std::vector<scene::ShapeRefPair> pairs;
  for (int link = 0; link < static_cast<int>(robot.robotModel().links.size()); ++link)
    if (objects.isChecked(link, object)) pairs.push_back({{link}, object});
  for (const int searcher : objects.searchers())
    if (searcher != number && objects.isChecked(scene::ShapeRef::ofObject(searcher), object))
      pairs.push_back({scene::ShapeRef::ofObject(searcher), object});
  scene::Question question;
  question.tolerance = robot.config().tolerance;
  return scenes.scene.minimum(scenes.state, pairs, question);
}

}  // namespace

std::vector<SensedSource> sensedSources(const Robot& robot, PosedScenes& scenes, bool is_known,
                                        const std::vector<SensedCloud>& clouds) {
  std::vector<SensedSource> sources;
  const scene::Objects& objects = *scenes.state.objects();
  for (const SensedCloud& cloud : clouds) {
    SensedSource& source = sources.emplace_back();
    source.name = cloud.source;
    source.age = ros::Duration(cloud.age);
    source.points = cloud.points;
    source.out_of_range = cloud.out_of_range;
    source.over_limit = cloud.over_limit;
    source.on_robot = cloud.on_robot;
    source.voxels = cloud.voxels;
    source.persistent = cloud.persistent;
    source.boxes = cloud.boxes;
    source.seconds = cloud.seconds;
    const int number = objects.find(source.name);
    const scene::PairProximity* const closest = is_known && number >= 0 ? closestTo(number, robot, scenes) : nullptr;
    source.minimum =
        closest ? toMessage({robot.robotModel(), &objects}, scenes.state.poses(), *closest, {}) : unknownProximity();
  }
  return sources;
}

}  // namespace proximity_server::node
