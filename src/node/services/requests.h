#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "node/robot/query_status.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/QueryPairsRequest.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/ShapeRef.h"

namespace proximity_server::node {

/// The error of a request that cannot be answered, with the code and message of its QueryStatus.
class RequestError : public std::runtime_error {
 public:
  explicit RequestError(const QueryStatus& status) : std::runtime_error(status.message), status_(status) {}
  RequestError(std::int8_t code, const std::string& message) : RequestError(statusOf(code, message)) {}

  const QueryStatus& status() const { return status_; }

 private:
  QueryStatus status_;
};

/// Throws RequestError INVALID_ARGUMENT.
[[noreturn]] void refuse(const std::string& what);

/// Throws RequestError unless the status is OK.
void require(const QueryStatus& status);

enum class Filter { Applies, Ignored };
inline Filter filterOf(bool ignore_filter) { return ignore_filter ? Filter::Ignored : Filter::Applies; }

// Checks of the numbers of a request.
// Failure: throw RequestError INVALID_ARGUMENT naming the number.
double finite(double value, const std::string& name);
double notNegative(double value, const std::string& name);
double positive(double value, const std::string& name);

/// Index of a link, with or without geometry. Throws RequestError UNKNOWN_LINK naming the nearest one.
int linkNamed(const scene::RobotModel& robot, const std::string& name);

/// The pairs that a request asks about: a list of its own, or all candidates of the robot, which must outlive it, with
/// all checked pairs of its objects. It keeps the objects of the moment of the request.
class RequestedPairs {
 public:
  RequestedPairs(const Robot& robot, RobotObjects objects, std::vector<scene::ShapeRefPair> pairs)
      : robot_(&robot), objects_(std::move(objects)), own_(std::move(pairs)) {}
  RequestedPairs(const Robot& robot, RobotObjects objects) : robot_(&robot), objects_(std::move(objects)) {}

  const scene::Objects& objects() const { return *objects_.all; }
  const std::shared_ptr<const scene::Objects>& sharedObjects() const { return objects_.all; }

  /// nullptr: all candidates.
  const std::vector<scene::ShapeRefPair>* list() const { return own_ ? &*own_ : nullptr; }
  std::size_t size() const;

  /// The pairs as a question to a scene takes them; it refers to this object.
  scene::Pairs asked() const { return own_ ? scene::Pairs(*own_) : scene::Pairs(robot_->candidates()); }

  /// The bodies and frames whose poses the pairs need.
  std::vector<int> bodies() const;
  AskedFrames frames() const;

  /// A scene that has the objects.
  ScenePool::Lease borrowScene() const;
  MovingScenePool::Lease borrowMovingScene() const;

 private:
  const Robot* robot_;
  RobotObjects objects_;
  std::optional<std::vector<scene::ShapeRefPair>> own_;
};

// Find the pairs that a request names, of links and of the objects that the robot has now. The pairs keep the request's
// order of a and b.
// Failure: throw RequestError for a link, shape or object that does not exist or has no geometry, for a pair that the
//          filter excludes, and if no pair is left.

/// If both are empty, every pair; if b is empty, all pairs with a; otherwise the pair of a and b.
RequestedPairs pairsOf(const Robot& robot, const ShapeRef& a, const ShapeRef& b, Filter filter);

/// The same for the lists of a batch. Also throws RequestError OVER_BUDGET if the lists name more than
/// Config::max_batch pairs, before it allocates memory for them.
RequestedPairs pairsOf(const Robot& robot, const QueryPairsRequest& request);

/// Throws RequestError OVER_BUDGET if the answers about so many states could return more than Config::max_batch pairs.
/// `asked` is the number of pairs in the question about each state; the mode of the request says how many of them an
/// answer returns.
void requireAnswersWithinBatch(const Robot& robot, const QueryPairsRequest& request, std::size_t asked,
                               std::size_t states = 1);

/// Throws RequestError OVER_BUDGET if a trajectory has more points than Config::max_batch.
void requirePointsWithinBatch(const Robot& robot, std::size_t points);

}  // namespace proximity_server::node
