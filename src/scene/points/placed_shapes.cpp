#include "scene/points/placed_shapes.h"

namespace proximity_server::scene {

void PlacedShapes::take(const State& state, const std::vector<ShapeRef>& shapes, All* all) {
  if (state.revision() == revision_ && shapes == asked_) return;
  revision_ = 0;  // if a shape does not exist, nothing is taken
  bounded_.clear();
  unbounded_.clear();
  unplaced_.clear();
  const PlacedRobot& robot = state.placed();
  std::vector<Eigen::AlignedBox3d> boxes;
  std::size_t asked = 0;
  for (const ShapeRef& shape : shapes.empty() ? all(state.robot(), *state.objects()) : shapes) {
    const std::size_t place = asked++;
    const int number = robot.numberOf(shape);
    if (!robot.isPlaced(number)) {
      unplaced_.push_back(shape);
      continue;
    }
    const Part& part = robot[number];
    (part.isUnbounded() ? unbounded_ : bounded_).push_back({shape, place, part, robot.poseOf(number)});
    if (!part.isUnbounded()) boxes.push_back(robot.worldBox(number));
  }
  tree_ = BoxTree(boxes);
  asked_ = shapes;
  revision_ = state.revision();
}

}  // namespace proximity_server::scene
