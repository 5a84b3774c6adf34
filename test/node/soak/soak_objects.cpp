#include "node/soak/soak_objects.h"

#include <algorithm>
#include <array>

#include "node/load/node_under_load.h"

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

SoakObjects::SoakObjects(const std::shared_ptr<const SceneModel>& model, SoakRecord& record, std::uint64_t seed)
    : model_(model), none_(noObjects(model)), record_(record), generator_(seed), thread_([this] { run(); }) {}

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
    std::this_thread::sleep_for(std::chrono::duration<double>(random(0.0, kLongestPause)));
  }
}

double SoakObjects::random(double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(generator_);
}

void SoakObjects::forget() {
  is_known_ = false;
  client_ = ros::ServiceClient();
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
  const std::string id = "ball " + std::to_string(static_cast<int>(random(0.0, kIds)));
  const bool is_there = now->find(id) >= 0;
  Change change;
  change.asked.id = id;
  if (is_there && random(0.0, 1.0) < 0.2) {
    change.asked.operation = proximity_server::ObjectChange::REMOVE;
    change.same = RemoveObject{id};
    return change;
  }
  change.asked.operation = proximity_server::ObjectChange::REPLACE;
  change.asked.primitives.resize(1);
  change.asked.primitives[0].type = shape_msgs::SolidPrimitive::SPHERE;
  change.asked.primitives[0].dimensions = {kRadius};
  const std::array<double, 3> at = {random(-1.0, 1.0), random(-1.0, 1.0), random(0.0, 1.5)};
  change.asked.pose.position.x = at[0];
  change.asked.pose.position.y = at[1];
  change.asked.pose.position.z = at[2];
  Eigen::Isometry3d pose(Eigen::Translation3d(at[0], at[1], at[2]));
  const std::vector<Link>& links = model_->robot.links;
  const std::string& link = links[static_cast<std::size_t>(random(0.0, static_cast<double>(links.size()) - 0.01))].name;
  Placement placement = Fixed{pose};
  const double kind = random(0.0, 1.0);
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
  if (!client_.isValid()) {
    client_ = ros::NodeHandle().serviceClient<ApplyObjectsRequest, ApplyObjectsResponse>(kNodeName + "/" + kService,
                                                                                         /*persistent=*/true);
  }
  ApplyObjectsRequest request;
  request.changes.changes = {asked};
  const int starts = record_.starts();
  const bool was_up = record_.nodeIsUp();
  if (client_.isValid() && client_.call(request, response)) {
    if (response.success) return true;
    record_.countWrong(kService, "refused: " + response.status.message);
    return false;
  }
  client_ = ros::ServiceClient();
  const bool excused = !was_up || !record_.nodeIsUp() || record_.starts() != starts || starts_seen_ != starts;
  starts_seen_ = starts;  // once: the connection of before is broken
  if (excused || record_.isStopped())
    record_.count(kService, Outcome::Lost);
  else
    record_.countWrong(kService, "the call was lost while the node was there");
  return false;
}

}  // namespace proximity_server::node
