#include "node/answers/statuses.h"

#include "node/robot/query_status.h"
#include "system/durations.h"

#include <string>

namespace proximity_server::node {

QueryStatus incompleteness(const Robot& robot, const scene::PairCounts& counts, const scene::Question& question,
                           const std::string& noun) {
  const std::string pairs =
      std::to_string(counts.unknown) + " of " + std::to_string(counts.total) + " " + noun + " have no ";
  if (!question.deadline.hasPassed()) return statusOf(QueryStatus::TF_UNAVAILABLE, pairs + "usable pose");
  return statusOf(QueryStatus::OVER_BUDGET, "the time was over: " + pairs + "answer, max_request_time is " +
                                                system::secondsText(robot.config().max_request_time));
}

QueryStatus completeness(const scene::MotionCounts& counts) {
  if (counts.unknown == 0) return {};
  return statusOf(QueryStatus::TF_UNAVAILABLE, std::to_string(counts.unknown) + " of " + std::to_string(counts.pairs) +
                                                   " pairs have no usable pose, or no geometry");
}

QueryStatus statusOf(narrowphase::Status status, const scene::MotionQuestion& question) {
  if (status == narrowphase::Status::Converged || status == narrowphase::Status::Threshold) return {};
  if (!question.deadline.hasPassed()) return statusOf(QueryStatus::NOT_CONVERGED, "undecided within the tolerance");
  return statusOf(QueryStatus::OVER_BUDGET, "the time budget ended; what is said is proven");
}

QueryStatus statusOfContact(const scene::RobotTimeOfContact& found, double t_free,
                            const scene::MotionQuestion& question) {
  const QueryStatus status = statusOf(found.status, question);
  if (found.contact || found.status != narrowphase::Status::Degenerate || status.code != QueryStatus::NOT_CONVERGED)
    return status;
  return statusOf(QueryStatus::NOT_CONVERGED, "from " + system::secondsText(t_free) +
                                                  " on there may be a contact, but no state is known that is one");
}

}  // namespace proximity_server::node
