#include "scene/query/object_visits.h"

#include <algorithm>

namespace proximity_server::scene {
namespace {

/// A tree that has grown so much looser is built anew. A larger number saves building; a smaller one saves visits.
constexpr double kTooLoose = 1.5;

}  // namespace

bool isCheckedPair(const PlacedRobot& robot, int a, int b) {
  const Objects* objects = robot.objects();
  const int number_a = a - robot.firstObject(), number_b = b - robot.firstObject();
  if (!objects || !objects->placed(number_b) || (number_a >= 0 && !objects->placed(number_a))) return false;
  const PairReason reason = number_a < 0 ? objects->linkReason(a, number_b) : objects->objectReason(number_a, number_b);
  return reason == PairReason::Checked;
}

/// Of two walkers only the one with the smaller number visits the other.
bool ObjectVisits::isCheckedHere(const PlacedRobot& robot, int walker, int object) {
  if (!isCheckedPair(robot, walker, object)) return false;
  const std::vector<int>& walkers = robot.objects()->walkers();
  return walker < object || !std::binary_search(walkers.begin(), walkers.end(), object - robot.firstObject());
}

void ObjectVisits::fit(const PlacedRobot& robot) {
  walkers_.clear();
  attached_.clear();
  unknown_pairs_ = 0;
  const Objects* objects = robot.objects();
  if (!objects || objects->empty()) return;
  const int first = robot.firstObject();
  for (int link = 0; link < static_cast<int>(objects->model().robot.links.size()); ++link) addWalker(robot, link);
  for (const int number : objects->walkers()) {
    if (objects->placed(number)->kind == PlacedObject::Kind::Attached) attached_.push_back(number);
    addWalker(robot, first + number);
  }
  fitMoving(robot);
  countUnknown(robot);
}

void ObjectVisits::addWalker(const PlacedRobot& robot, int root) {
  if (!robot.isPlaced(root)) return;
  const bool is_unbounded = robot.isUnbounded(root);
  walkers_.push_back({static_cast<int>(walkers_.size()), root, is_unbounded,
                      is_unbounded ? Eigen::AlignedBox3d() : robot.worldBox(root)});
}

/// The boxes of moving objects. One whose pose is missing has an empty box, so that nothing comes near it.
void ObjectVisits::fitMoving(const PlacedRobot& robot) {
  std::vector<int>& numbers = scratch_;
  numbers.clear();
  moving_boxes_.clear();
  for (const int number : robot.objects()->moving()) {
    const int object = robot.firstObject() + number;
    if (robot.isUnbounded(object)) continue;
    numbers.push_back(number);
    moving_boxes_.push_back(robot.isPlaced(object) ? robot.worldBox(object) : Eigen::AlignedBox3d());
  }
  if (numbers == moving_) moving_tree_.refit(moving_boxes_);
  if (numbers == moving_ && moving_tree_.looseness() <= kTooLoose) return;
  moving_ = numbers;
  moving_tree_ = BoxTree(moving_boxes_);
}

void ObjectVisits::countUnknown(const PlacedRobot& robot) {
  const Objects& objects = *robot.objects();
  const int first = robot.firstObject();
  missing_.clear();
  const auto missesItsPose = [&](int number) { return !robot.isPlaced(first + number); };
  for (const int number : objects.moving())
    if (missesItsPose(number)) missing_.push_back(number);
  for (const int number : attached_)
    if (missesItsPose(number)) missing_.push_back(number);
  for (int link = 0; link < static_cast<int>(objects.model().robot.links.size()); ++link) {
    if (robot.at(link).isEmpty()) continue;
    for (const int number : robot.isPlaced(link) ? missing_ : objects.numbers())
      unknown_pairs_ += objects.linkReason(link, number) == PairReason::Checked;
  }
  const std::vector<int>& walkers = objects.walkers();
  for (const int walker : walkers) {
    for (const int number : missesItsPose(walker) ? objects.numbers() : missing_) {
      // Of two walkers without a pose the one with the smaller number counts, of one without a pose only that one.
      const bool is_walker = std::binary_search(walkers.begin(), walkers.end(), number);
      const bool was_counted = is_walker && missesItsPose(number) && (!missesItsPose(walker) || number < walker);
      unknown_pairs_ += !was_counted && objects.objectReason(walker, number) == PairReason::Checked;
    }
  }
}

void ObjectVisits::push(const NodeVisit& visit, double limit) {
  if (visit.lower_bound > limit) return;
  queue_.push_back(visit);
  std::push_heap(queue_.begin(), queue_.end());
}

ObjectVisits::NodeVisit ObjectVisits::pop() {
  std::pop_heap(queue_.begin(), queue_.end());
  const NodeVisit visit = queue_.back();
  queue_.pop_back();
  return visit;
}

/// -1 if the object is not there any more as it was.
int ObjectVisits::objectOf(Tree tree, int item, const PlacedRobot& robot) const {
  if (tree == Tree::Moving) return moving_[static_cast<std::size_t>(item)];
  const FixedObjects::Item& entry = robot.objects()->fixed().item(item);
  const PlacedObject* object = robot.objects()->placed(entry.number);
  return object && object->serial == entry.serial ? entry.number : -1;
}

}  // namespace proximity_server::scene
