#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "node/robot/robot.h"
#include "proximity_server/QueryPairsRequest.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/ShapeRef.h"

namespace proximity_server::node {

/// A request that cannot be answered: code and message of its QueryStatus.
class RequestError : public std::runtime_error {
 public:
  RequestError(std::int8_t code, const std::string& message) : std::runtime_error(message), code_(code) {}
  explicit RequestError(const QueryStatus& status) : RequestError(status.code, status.message) {}

  QueryStatus status() const;

 private:
  std::int8_t code_;
};

enum class Filter { Applies, Ignored };
inline Filter filterOf(bool ignore_filter) { return ignore_filter ? Filter::Ignored : Filter::Applies; }

// Numbers of a request. Failure: throw RequestError INVALID_ARGUMENT naming the number.
double finite(double value, const std::string& name);
double notNegative(double value, const std::string& name);
double positive(double value, const std::string& name);

/// Index of a link, with or without geometry. Throws RequestError UNKNOWN_LINK naming the nearest one.
int linkNamed(const scene::RobotModel& robot, const std::string& name);

// Finds the pairs that a request names. The pairs keep the request's order of a and b.
// Failure: throw RequestError for a link or shape that does not exist or has no geometry, for a pair that the filter
//          excludes, and where no pair is left.

/// Both empty: every pair; b empty: a against all others; else that one pair.
std::vector<scene::ShapeRefPair> pairsOf(const Robot& robot, const ShapeRef& a, const ShapeRef& b, Filter filter);

/// The same for the lists of a batch. Throws also where these are more than Config::max_batch pairs, before they take
/// any memory.
std::vector<scene::ShapeRefPair> pairsOf(const Robot& robot, const QueryPairsRequest& request);

/// Throws RequestError OVER_BUDGET where the answers about so many states could return more than Config::max_batch
/// pairs: `asked` is how many are asked about in each of them, and the mode of the request says how many of these come
/// back.
void requireAnswersWithinBatch(const Robot& robot, const QueryPairsRequest& request, std::size_t asked,
                               std::size_t states = 1);

/// Throws RequestError OVER_BUDGET where a trajectory has more points than Config::max_batch.
void requirePointsWithinBatch(const Robot& robot, std::size_t points);

/// The bodies of all links in `pairs`, each once.
std::vector<int> bodiesOf(const scene::RobotModel& robot, const std::vector<scene::ShapeRefPair>& pairs);

}  // namespace proximity_server::node
