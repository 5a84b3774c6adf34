#include "node/soak/soak_objects.h"

#include "node/load/node_under_load.h"

#include <algorithm>

namespace proximity_server::node {

using namespace narrowphase;
using namespace scene;
namespace {

using Outcome = SoakRecord::Outcome;

const std::string kService = "apply_objects";
constexpr double kLongestPause = 0.05;  // [s] between two changes, on average half of it
constexpr std::size_t kHistory = 2000;  // as many changes as no answer is old
constexpr int kIds = 8;                 // so that most changes find an object
constexpr double kRadius = 0.05;        // [m]

/// The base stands still: it is the reference frame.
SoakObjects::Set noObjects(const std::shared_ptr<const SceneModel>& model) {
  ObjectRules rules;
  rules.base = ObjectRules::Base::StandsStill;
  return std::make_shared<const Objects>(Objects(model).withRules(rules));
}

}  // namespace

SoakObjects::SoakObjects(const std::shared_ptr<const SceneModel>& model, SoakRecord& record, unsigned seed)
    : model_(model), none_(noObjects(model)), record_(record), chance_(seed), calls_(record), thread_([this] {
        run();
      }) {}

SoakObjects::Set SoakObjects::ofRevision(std::uint64_t revision) const {
  if (revision == 0) return none_;
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto entry = history_.rbegin(); entry != history_.rend(); ++entry)
    if (entry->revision == revision) return entry->objects;
  return nullptr;
}

std::vector<SoakObjects::Set> SoakObjects::since(Clock::time_point begin) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<Set> sets;
  if (history_.empty() || history_.front().from > begin) return sets;
  for (const Entry& entry : history_)
    if (entry.until >= begin) sets.push_back(entry.objects);
  return sets;
}

void SoakObjects::run() {
  while (!record_.isStopped()) {
    if (is_known_ || beginAnew()) changeOnce();
    std::this_thread::sleep_for(std::chrono::duration<double>(chance_.between(0.0, kLongestPause)));
  }
}

void SoakObjects::forget() {
  is_known_ = false;
  calls_.disconnect();
  const std::lock_guard<std::mutex> lock(mutex_);
  history_.clear();
}

/// Whether the node has none of our objects now.
bool SoakObjects::beginAnew() {
  proximity_server::ObjectChange remove;
  remove.operation = proximity_server::ObjectChange::REMOVE;
  remove.id = "*";
  ApplyObjectsResponse response;
  if (!apply(remove, response)) return false;
  node_start_ = response.node_start;
  is_known_ = true;
  const std::lock_guard<std::mutex> lock(mutex_);
  history_ = {{response.revision, none_, Clock::now(), Clock::time_point::max()}};
  return true;
}

void SoakObjects::changeOnce() {
  const Change change = randomChange();
  {
    // Known before the node can tell anybody of it.
    const std::lock_guard<std::mutex> lock(mutex_);
    const Entry& now = history_.back();
    history_.push_back({now.revision + 1, std::make_shared<const Objects>(now.objects->changed({change.same})),
                        Clock::now(), Clock::time_point::max()});
    if (history_.size() > kHistory) history_.pop_front();
  }
  ApplyObjectsResponse response;
  if (!apply(change.asked, response) || response.node_start != node_start_) return forget();
  const std::lock_guard<std::mutex> lock(mutex_);
  history_[history_.size() - 2].until = Clock::now();
  if (response.revision == history_.back().revision) return record_.count(kService, Outcome::Right);
  record_.countWrong(kService, "revision " + std::to_string(response.revision) + " instead of " +
                                   std::to_string(history_.back().revision));
}

/// A new ball, another place for one, or one less.
SoakObjects::Change SoakObjects::randomChange() {
  const Set& now = history_.back().objects;  // only this thread writes it
  const std::string id = "ball " + std::to_string(chance_.below(kIds));
  const bool is_there = now->find(id) >= 0;
  Change change;
  change.asked.id = id;
  if (is_there && chance_.happens(0.2)) {
    change.asked.operation = proximity_server::ObjectChange::REMOVE;
    change.same = RemoveObject{id};
    return change;
  }
  change.asked.operation = proximity_server::ObjectChange::REPLACE;
  change.asked.primitives.resize(1);
  change.asked.primitives[0].type = shape_msgs::SolidPrimitive::SPHERE;
  change.asked.primitives[0].dimensions = {kRadius};
  geometry_msgs::Point& at = change.asked.pose.position;
  at.x = chance_.between(-1.0, 1.0);
  at.y = chance_.between(-1.0, 1.0);
  at.z = chance_.between(0.0, 1.5);
  const Eigen::Isometry3d pose(Eigen::Translation3d(at.x, at.y, at.z));
  const std::vector<Link>& links = model_->robot.links;
  const std::string& link = chance_.oneOf(links).name;
  Placement placement = Fixed{pose};
  const double kind = chance_.between(0.0, 1.0);
  if (kind < 0.5 && link != links.front().name) {
    change.asked.header.frame_id = link;  // then tf is not asked where it is
    if (kind < 0.25) {
      change.asked.link = link;
      placement = Attached{link, {}, pose};
    } else {
      change.asked.frame = link;
      placement = Moving{link, pose};
    }
  }
  const Object object = makeObject(id, {{Shape(Sphere{kRadius})}}, placement);
  if (is_there)
    change.same = ReplaceObject{object};
  else
    change.same = AddObject{object};
  return change;
}

/// Whether the node has answered and done it.
bool SoakObjects::apply(const proximity_server::ObjectChange& asked, ApplyObjectsResponse& response) {
  ApplyObjectsRequest request;
  request.changes.changes = {asked};
  if (!calls_.call(kService, request, response)) return false;
  if (!response.success) record_.countWrong(kService, "refused: " + response.status.message);
  return response.success;
}

}  // namespace proximity_server::node
