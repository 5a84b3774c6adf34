#include "node/sources/cloud_colours.h"

#include "node/robot/level_colour.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/points/point_search.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace proximity_server::node {
namespace {

std::uint32_t rgbOf(Clearance::_level_type level) {
  const std_msgs::ColorRGBA colour = levelColour(level);
  std::uint32_t rgb = 0;
  for (const float part : {colour.r, colour.g, colour.b})
    rgb = (rgb << 8U) | static_cast<std::uint32_t>(std::lround(255.0f * part));
  return rgb;
}

}  // namespace

std::vector<std::uint32_t> coloursOf(const Robot& robot, const std::shared_ptr<const scene::Objects>& objects,
                                     const std::string& source, const scene::BodyPoses& poses,
                                     const std::vector<Eigen::Vector3d>& points) {
  std::vector<std::uint32_t> colours(points.size(), rgbOf(Clearance::CLEAR));
  const int number = objects->find(source);
  if (number < 0 || points.empty()) return colours;
  const scene::ShapeRef object = scene::ShapeRef::ofObject(number);
  scene::Points asked{points};
  for (const scene::ShapeRef& shape : scene::shapesOfRobot(robot.robotModel(), *objects))
    if (objects->isChecked(shape, object)) asked.shapes.push_back(shape);
  if (asked.shapes.empty()) return colours;
  const scene::LevelThresholds thresholds = robot.thresholdsWith(*objects);
  const double stop = thresholds.stop.of({asked.shapes[0], object}),
               warn = thresholds.warn.of({asked.shapes[0], object});
  scene::State state(robot.sharedModel());
  state.set(objects);
  state.set(poses);
  scene::Question question;
  question.threshold = warn;
  scene::PointSearch search(robot.sharedModel());
  const std::vector<scene::PairProximity>& closest = search.closest(state, asked, question);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double distance = closest[i].result.lower_bound;  // beyond the threshold there is no other number
    if (distance <= warn) colours[i] = rgbOf(distance <= stop ? Clearance::STOP : Clearance::WARN);
  }
  return colours;
}

}  // namespace proximity_server::node
