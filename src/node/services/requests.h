#pragma once

#include "node/robot/query_status.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/QueryPairsRequest.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/ShapeRef.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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

/// Throws RequestError INVALID_ARGUMENT with this message.
[[noreturn]] void refuse(const std::string& what);

/// Throws RequestError unless the status is OK.
void require(const QueryStatus& status);

enum class Filter { Applies, Ignored };
inline Filter filterOf(bool ignore_filter) { return ignore_filter ? Filter::Ignored : Filter::Applies; }

// These functions return a number of a request if it is valid.
// Failure: they throw RequestError INVALID_ARGUMENT naming the number.
double finite(double value, const std::string& name);
double notNegative(double value, const std::string& name);
double positive(double value, const std::string& name);

/// The index of a link, which may have no geometry. Throws RequestError UNKNOWN_LINK with the nearest name if there is
/// none.
int linkNamed(const scene::RobotModel& robot, const std::string& name);

/// The pairs that a request asks about: either a list, or all candidates of the robot with all checked pairs of its
/// objects. The objects are those at the time of the request. The robot must outlive it.
class RequestedPairs {
 public:
  RequestedPairs(const Robot& robot, RobotObjects objects, std::vector<scene::ShapeRefPair> pairs)
      : robot_(&robot), objects_(std::move(objects)), own_(std::move(pairs)) {}
  RequestedPairs(const Robot& robot, RobotObjects objects) : robot_(&robot), objects_(std::move(objects)) {}

  const scene::Objects& objects() const { return *objects_.all; }

  /// The list of pairs; nullptr if all checked pairs are requested.
  const std::vector<scene::ShapeRefPair>* list() const { return own_ ? &*own_ : nullptr; }
  std::size_t size() const;

  /// The pairs for a question to a scene. The result refers to this object.
  scene::Pairs asked() const { return own_ ? scene::Pairs(*own_) : scene::Pairs(robot_->candidates()); }

  /// The bodies and frames whose poses the pairs need.
  std::vector<int> bodies() const;
  CarrierFrames frames() const;

  /// Lends a state that has the objects, with its scenes.
  ScenePool::Lease borrowScenes() const;

 private:
  const Robot* robot_;
  RobotObjects objects_;
  std::optional<std::vector<scene::ShapeRefPair>> own_;
};

// These functions find the pairs that a request names, of links and of the present objects of the robot. They keep the
// order of a and b.
// Failure: they throw RequestError for a link, shape or object that does not exist or has no geometry, for a pair that
//          the filter excludes, and if no pair is left.

/// Returns every pair if both are empty, all pairs with a if b is empty, and otherwise the pair of a and b.
RequestedPairs pairsOf(const Robot& robot, const ShapeRef& a, const ShapeRef& b, Filter filter);

/// Returns the pairs of the lists of a request. It also throws RequestError OVER_BUDGET if the lists name more than
/// Config::max_batch pairs, and then has not allocated memory for all of them.
RequestedPairs pairsOf(const Robot& robot, const QueryPairsRequest& request);

/// Which shapes count if a request names none.
enum class Unnamed { RobotWithHeld, Everything };

/// Returns each shape of a list as a pair with itself: what a question about points or rays asks about.
RequestedPairs shapesOf(const Robot& robot, const std::vector<ShapeRef>& shapes, Unnamed unnamed);

/// The largest number of pairs that the mode returns for one state if it checks this many.
std::size_t maxReturned(const QueryPairsRequest& request, std::size_t checked);

/// Throws RequestError OVER_BUDGET if the answers about `states` states could return more than Config::max_batch pairs.
/// `pairs` is the number of pairs in the question about each state; by the mode of the request an answer may return
/// fewer.
void requireAnswersWithinBatch(const Robot& robot, const QueryPairsRequest& request, std::size_t pairs,
                               std::size_t states = 1);

/// Throws RequestError OVER_BUDGET if a field has more points or rays than Config::max_batch.
void requireWithinBatch(const Robot& robot, const std::string& field, std::size_t count, const std::string& noun);

}  // namespace proximity_server::node
