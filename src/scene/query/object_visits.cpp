#include "scene/query/object_visits.h"

#include <algorithm>

namespace proximity_server::scene {
namespace {

/// A tree that has become looser than this factor is built anew. A larger number saves building; a smaller one saves
/// visits.
constexpr double kTooLoose = 1.5;

}  // namespace

bool isCheckedPair(const PlacedRobot& robot, int a, int b) {
  const ShapeRef ref_a = robot.refOf(a), ref_b = robot.refOf(b);
  for (const ShapeRef& ref : {ref_a, ref_b})
    if (ref.isObject() && !robot.objects()->placed(ref.object())) return false;
  return robot.objects()->isChecked(ref_a, ref_b);
}

void ObjectVisits::fit(const PlacedRobot& robot) {
  searchers_.clear();
  forgetSearch();  // its visits point to them
  are_boxes_placed_ = false;
  attached_.clear();
  unknown_pairs_ = 0;
  const Objects* objects = robot.objects().get();
  if (objects->empty()) return;
  for (int link = 0; link < static_cast<int>(objects->model().robot.links.size()); ++link) addSearcher(robot, link);
  for (const int number : objects->searchers()) {
    if (objects->placed(number)->kind == PlacedObject::Kind::Attached) attached_.push_back(number);
    addSearcher(robot, robot.numberOfObject(number));
  }
  countUnknown(robot);
}

/// Places the boxes of searchers and moving objects in the latest poses. Many questions end before they are needed.
void ObjectVisits::placeBoxes(const PlacedRobot& robot) {
  if (are_boxes_placed_) return;
  for (Searcher& searcher : searchers_) {
    if (searcher.is_unbounded) continue;
    searcher.box = robot.worldBox(searcher.part);
    searcher.rounded_box = WideTree::boxOf(searcher.box);
  }
  fitMoving(robot);
  are_boxes_placed_ = true;
}

void ObjectVisits::forgetSearch() {
  near_.clear();
  left_out_.clear();
  lowest_left_out_ = kInfinity;
  most_ = kNearest;
}

/// Finds the nearest leaves below the nodes that were left out, and leaves out the others.
void ObjectVisits::findNearest(const PlacedRobot& robot, double limit) {
  starts_.swap(left_out_);
  left_out_.clear();
  lowest_left_out_ = kInfinity;
  if (starts_.size() > most_)
    std::nth_element(starts_.begin(), starts_.begin() + static_cast<std::ptrdiff_t>(most_), starts_.end());
  double farthest = limit;
  for (const NodeVisit& start : starts_) farthest = searchBelow(robot, start, farthest, limit);
  std::sort(near_.rbegin(), near_.rend());
  most_ *= 2;
}

/// Adds the leaves below a node that are within `farthest` [m]. Returns `farthest`, or less if there are too many.
double ObjectVisits::searchBelow(const PlacedRobot& robot, const NodeVisit& start, double farthest, double limit) {
  const BoxTree& boxes = treeOf(start.tree, robot);
  NodeVisit visit = start;
  for (open_.assign(1, start); !open_.empty();) {
    static_cast<Bounded&>(visit) = open_.back();
    open_.pop_back();
    const bool is_leaf = visit.kind == Bounded::Kind::Leaf;
    if (is_leaf && !(visit.lower_bound > farthest))
      visit.lower_bound = boxGap(visit.searcher->box, boxes[visit.node].box);
    if (visit.lower_bound > farthest) {
      leaveOut(visit, limit);
    } else if (is_leaf) {
      near_.push_back(visit);
      if (near_.size() >= 2 * most_) farthest = keepNearest(limit);
    } else {
      openChildren(robot, visit, farthest, limit);
    }
  }
  return farthest;
}

/// Opens the children of a node that are within `farthest` [m], the nearest next.
void ObjectVisits::openChildren(const PlacedRobot& robot, const NodeVisit& parent, double farthest, double limit) {
  const WideTree& wide = wideTreeOf(parent.tree, robot);
  const WideTree::Lanes gaps = wide.gaps(parent.searcher->rounded_box, parent.node);
  const std::size_t first = open_.size();
  for (int lane = 0; lane < WideTree::kLanes; ++lane) {
    const auto gap = static_cast<double>(gaps[lane]);
    const WideTree::Child& child = wide[parent.node].children[lane];
    if (gap > limit || child.in_box_tree < 0) continue;
    Bounded next{gap, child.node, Bounded::Kind::Inner};
    if (child.node < 0) next = {gap, child.in_box_tree, Bounded::Kind::Leaf};
    if (gap > farthest) {
      leaveOut({next, parent.tree, parent.searcher}, limit);
      continue;
    }
    open_.push_back(next);
    for (std::size_t i = open_.size() - 1; i > first && open_[i - 1].lower_bound < open_[i].lower_bound; --i)
      std::swap(open_[i - 1], open_[i]);
  }
}

void ObjectVisits::leaveOut(const NodeVisit& visit, double limit) {
  if (visit.lower_bound > limit || visit.lower_bound == kInfinity) return;
  left_out_.push_back(visit);
  lowest_left_out_ = std::min(lowest_left_out_, visit.lower_bound);
}

/// Keeps about as many leaves as wanted, the nearest ones. Returns the largest of their bounds [m].
double ObjectVisits::keepNearest(double limit) {
  const auto end = near_.begin() + static_cast<std::ptrdiff_t>(most_);
  std::nth_element(near_.begin(), end - 1, near_.end());
  const double farthest = (end - 1)->lower_bound;
  std::for_each(end, near_.end(), [&](const NodeVisit& visit) { leaveOut(visit, limit); });
  near_.erase(end, near_.end());
  return farthest;
}

void ObjectVisits::addSearcher(const PlacedRobot& robot, int part) {
  if (!robot.isPlaced(part)) return;
  const bool is_unbounded = robot[part].isUnbounded();
  searchers_.push_back({part, robot.refOf(part), is_unbounded, {}, {}});
}

/// Fits the boxes of moving objects. An object without a pose gets an empty box, so that nothing is near it.
void ObjectVisits::fitMoving(const PlacedRobot& robot) {
  std::vector<int>& numbers = scratch_;
  numbers.clear();
  moving_boxes_.clear();
  for (const int number : robot.objects()->moving()) {
    const int object = robot.numberOfObject(number);
    if (robot[object].isUnbounded()) continue;
    numbers.push_back(number);
    moving_boxes_.push_back(robot.isPlaced(object) ? robot.worldBox(object) : Eigen::AlignedBox3d());
  }
  if (numbers == moving_) moving_tree_.refit(moving_boxes_);
  if (numbers == moving_ && moving_tree_.looseness() <= kTooLoose) return moving_wide_tree_.refit(moving_tree_);
  moving_ = numbers;
  moving_tree_ = BoxTree(moving_boxes_);
  moving_wide_tree_ = WideTree(moving_tree_);
}

void ObjectVisits::countUnknown(const PlacedRobot& robot) {
  const Objects& objects = *robot.objects();
  missing_.clear();
  const auto isMissing = [&](int number) { return !robot.isPlaced(robot.numberOfObject(number)); };
  std::copy_if(objects.moving().begin(), objects.moving().end(), std::back_inserter(missing_), isMissing);
  std::copy_if(attached_.begin(), attached_.end(), std::back_inserter(missing_), isMissing);
  for (int link = 0; link < static_cast<int>(objects.model().robot.links.size()); ++link) {
    if (robot[link].whole().isEmpty()) continue;
    for (const int number : robot.isPlaced(link) ? missing_ : objects.numbers())
      unknown_pairs_ += objects.isChecked(link, ShapeRef::ofObject(number));
  }
  const std::vector<int>& searchers = objects.searchers();
  for (const int searcher : searchers) {
    for (const int number : isMissing(searcher) ? objects.numbers() : missing_) {
      // A pair of two searchers without a pose is counted for the searcher with the smaller number. If only one of the
      // two has no pose, the pair is counted for that one.
      const bool is_searcher = std::binary_search(searchers.begin(), searchers.end(), number);
      const bool was_counted = is_searcher && isMissing(number) && (!isMissing(searcher) || number < searcher);
      unknown_pairs_ += !was_counted && objects.isChecked(ShapeRef::ofObject(searcher), ShapeRef::ofObject(number));
    }
  }
}

/// The number of the object of an item of a tree; -1 if the object is gone or has changed.
int ObjectVisits::objectOf(Tree tree, int item, const PlacedRobot& robot) const {
  if (tree == Tree::Moving) return moving_[item];
  const FixedObjects::Item& entry = robot.objects()->fixed().item(item);
  const PlacedObject* object = robot.objects()->placed(entry.number);
  return object && object->serial == entry.serial ? entry.number : -1;
}

}  // namespace proximity_server::scene
