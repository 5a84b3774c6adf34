#include "scene/batch/batch_objects.h"

#include "proximity_server/scene/motion/frames_on_links.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

/// The link with which an object moves.
int linkOf(const PlacedObject& object, const RobotModel& robot) {
  try {
    return carryingLink(robot, object.object);
  } catch (const std::invalid_argument& error) {
    refuseObject(object.object.id, error.what());
  }
}

/// The signed distance of a point from a box, in the frame of its body.
double distanceFromBox(const Vector3d& point, const Bounds& box) {
  const Vector3d gaps = (box.axes.transpose() * (point - box.centre)).cwiseAbs() - box.half;
  const double largest = gaps.maxCoeff();
  return largest > 0.0 ? gaps.cwiseMax(0.0).norm() : largest;
}

/// A lower bound of the distance of a point from the pieces of a volume, whose box is `of_box` away; any larger number
/// if it is at least `most`.
double distanceFromPieces(const Vector3d& point, const std::vector<Volume>& volumes, const Volume& here, double of_box,
                          double most) {
  if (here.isLeaf() || of_box >= most) return of_box;
  double distance = kInfinity;
  const auto boxOf = [&](int part) { return distanceFromBox(point, volumes[part].bounds); };
  for (const auto& [of_part, part] : smallerFirst(here.parts, boxOf))
    distance = std::min(distance, distanceFromPieces(point, volumes, volumes[part], of_part, std::min(most, distance)));
  return distance;
}

}  // namespace

BatchObjects::BatchObjects(std::shared_ptr<const Objects> of_robot, const std::vector<Visit>& visits, std::size_t first,
                           const Volumes& volumes, const LaneModel& lanes)
    : objects(std::move(of_robot)) {
  const RobotModel& robot = objects->model().robot;
  for (const int number : objects->moving()) linkOf(*objects->placed(number), robot);
  for (const std::string& frame : objects->frames()) frame_links.push_back(robot.findLink(frame));

  // The index of each part that is carried, or fixed; -1: it is not.
  std::vector<int> carried_of(static_cast<std::size_t>(volumes.rootCount() + objects->numberLimit()), -1);
  std::vector<int> fixed_of = carried_of;
  const auto add = [&](int part) {
    if (carried_of[part] >= 0 || fixed_of[part] >= 0) return;
    const bool is_object = part >= volumes.rootCount();
    const PlacedObject* const object = is_object ? objects->placed(part - volumes.rootCount()) : nullptr;
    if (object && object->kind == PlacedObject::Kind::Fixed) {
      fixed_of[part] = static_cast<int>(fixed.size());
      fixed.push_back(object);
    } else {
      carried_of[part] = static_cast<int>(carried.size());
      addCarried(object ? partOf(*object) : volumes.part(part), lanes);
    }
  };
  for (std::size_t i = first; i < visits.size(); ++i)
    for (const int part : {visits[i].a, visits[i].b}) add(part);

  numbers.assign(carried.size(), std::vector<int>(fixed.size(), -1));
  for (std::size_t i = first; i < visits.size(); ++i) {
    int a = visits[i].a, b = visits[i].b;
    if (carried_of[a] < 0) std::swap(a, b);
    const auto number = static_cast<int>(i);
    if (fixed_of[b] >= 0)
      numbers[carried_of[a]][fixed_of[b]] = number;
    else
      carried_pairs.push_back({number, carried_of[a], carried_of[b]});
  }
  std::vector<Eigen::AlignedBox3d> boxes;  // the box of an object with half-spaces is empty, so infinitely far away
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    boxes.push_back(fixed[i]->box);
    if (fixed[i]->isUnbounded()) unbounded.push_back(static_cast<int>(i));
  }
  tree = BoxTree(boxes);
}

void BatchObjects::addCarried(const Part& part, const LaneModel& lanes) {
  int body = part.body;
  Bounds bounds = part.whole().bounds;
  if (part.isFree()) {  // its frame is a link
    const RobotModel& robot = objects->model().robot;
    const Link& link = robot.links[linkOf(*part.object, robot)];
    body = link.body;
    bounds.centre = link.body_T_link * bounds.centre;
    bounds.reach += link.body_T_link.translation().norm();
  }
  const LaneError& error = lanes.body_errors[body];
  const double length = bounds.centre.norm();
  // The centre is rounded to float.
  const double in_float = 2.0 * 0x1p-24 * (length + error.reach);
  const double in_double = kPoseRounding * (length + error.reach + bounds.reach);
  carried.push_back({body, bounds.centre, part.isUnbounded() ? kInfinity : bounds.radius,
                     1.01 * (error.origin + error.rotation * length) + in_float + in_double});
}

double BatchObjects::distanceFrom(const Vector3d& point, int fixed_object, double most) const {
  const PlacedObject& object = *fixed[fixed_object];
  const Vector3d from_origin = point - object.world_T_object.translation();
  const Vector3d in_object = object.world_T_object.linear().transpose() * from_origin;
  double distance = kInfinity, lengths = from_origin.norm() + point.norm();
  for (const PlacedHalfSpace& half_space : object.geometry->halfSpaces()) {
    distance = std::min(distance, half_space.normal.dot(in_object) - half_space.offset);
    lengths = std::max(lengths, from_origin.norm() + point.norm() + half_space.chain_length);
  }
  if (const Volume& root = object.geometry->root(); !root.isEmpty()) {
    const double of_box = distanceFromBox(in_object, root.bounds);
    // A point inside of a closed mesh may be outside of the boxes of all its pieces.
    const double of_pieces =
        root.has_interior ? of_box : distanceFromPieces(in_object, object.geometry->volumes(), root, of_box, most);
    distance = std::min(distance, of_pieces);
    lengths += root.bounds.reach;
  }
  return distance - kPoseRounding * lengths;
}

}  // namespace proximity_server::scene
