#include "node/monitor/constraints.h"

#include "node/answers/gradients.h"
#include "node/answers/guarantees.h"
#include "node/robot/load_config.h"
#include "node/robot/query_status.h"

#include <string>

namespace proximity_server::node {
namespace {

void assignStart(ConstraintRows& message, const MeasuredCycle& cycle, const QueryStatus& status) {
  message.header = cycle.clearance.header;
  message.status = status;
  assignColumns(message.joint_names, cycle.scenes.state.degreesOfFreedom());
  assignPositions(message.joint_positions, cycle.scenes.state, cycle.snapshot.poses);
}

}  // namespace

Constraints::Constraints(const Robot& robot, int capacity)
    : config_(robot.config()),
      rows_(robot.sharedModel(), capacity, robot.constraintColumns()),
      inequality_rows_(robot.sharedModel(), robot.constraintColumns()) {}

const ConstraintRows& Constraints::rowsOf(const MeasuredCycle& cycle, const MonitorSettings& settings) {
  const QueryStatus status = update(cycle, settings);
  ConstraintRows& message = status.code == QueryStatus::OK ? message_ : empty_message_;
  assignStart(message, cycle, status);
  if (status.code == QueryStatus::OK) assignRows(cycle);
  return message;
}

QueryStatus Constraints::update(const MeasuredCycle& cycle, const MonitorSettings& settings) {
  if (cycle.clearance.level == Clearance::INVALID) return cycle.clearance.status;
  const std::string problem = problemOfInfluenceDistance(settings, config_);
  if (!problem.empty()) return statusOf(QueryStatus::INVALID_ARGUMENT, problem);
  damper_.stop = cycle.stop;
  damper_.influence_distance = settings.influence_distance;
  damper_.gain = settings.damping_gain;
  if (cycle.guaranteed) {
    damper_.guaranteed = [distances = cycle.guaranteed, &state = cycle.scenes.state](const scene::PairProximity& pair) {
      return distances->of(state, pair);
    };
    damper_.largest_loss = cycle.guaranteed->largestLoss(cycle.scenes.state);
  }
  rows_.find(cycle.scenes.scene, cycle.scenes.state, damper_);
  if (rows_.unknown() > 0)
    return statusOf(QueryStatus::NOT_CONVERGED, std::to_string(rows_.unknown()) +
                                                    " pairs within influence_distance have no distance or no gradient");
  const double rate = settings.damping_gain / (settings.influence_distance - cycle.stop.links);
  if (inequality_rows_.update(cycle.snapshot.poses, cycle.snapshot.stated, rate)) {
    QueryStatus status;
    if (cycle.guaranteed) appendEnd(status.message, "", *cycle.guaranteed);
    return status;
  }
  return statusOf(QueryStatus::TF_UNAVAILABLE, "the position of a joint of an inequality is not known");
}

void Constraints::assignRows(const MeasuredCycle& cycle) {
  const auto size = static_cast<std::size_t>(capacity());
  message_.matrix.assign(rows_.matrix().data(), rows_.matrix().data() + rows_.matrix().size());
  message_.lower_bounds.assign(rows_.bounds().data(), rows_.bounds().data() + rows_.bounds().size());
  message_.a.resize(size);
  message_.b.resize(size);
  message_.distances.resize(size);
  message_.unique.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    const scene::ConstraintRows::Row& row = rows_.rows()[i];
    const auto assign_name = [&](ShapeRef& message, const scene::ShapeRef& ref) {
      reserveNames(message, cycle.longest_name);
      row.is_used ? assign(message, cycle.model, ref) : clear(message);
    };
    assign_name(message_.a[i], row.pair.a);
    assign_name(message_.b[i], row.pair.b);
    message_.distances[i] = row.is_used ? row.distance : kNaN;
    message_.unique[i] = row.unique;
  }
  assignInequalities();
  message_.left_out = static_cast<std::uint32_t>(rows_.leftOut());
  message_.unneeded = static_cast<std::uint32_t>(rows_.unneeded());
  assignStuck(cycle);
}

/// Adds the rows of the inequalities. Their places in the lists of pairs stay empty.
void Constraints::assignInequalities() {
  const auto& matrix = inequality_rows_.matrix();
  const auto& bounds = inequality_rows_.bounds();
  message_.matrix.insert(message_.matrix.end(), matrix.data(), matrix.data() + matrix.size());
  message_.lower_bounds.insert(message_.lower_bounds.end(), bounds.data(), bounds.data() + bounds.size());
  const std::size_t size = message_.lower_bounds.size();
  message_.a.resize(size);
  message_.b.resize(size);
  message_.distances.resize(size, kNaN);
  message_.unique.resize(size, 1);
}

void Constraints::assignStuck(const MeasuredCycle& cycle) {
  const std::vector<scene::ConstraintRows::Stuck>& stuck = rows_.stuck();
  message_.stuck_a.resize(stuck.size());
  message_.stuck_b.resize(stuck.size());
  message_.stuck_distances.resize(stuck.size());
  message_.stuck_rates.resize(stuck.size());
  for (std::size_t i = 0; i < stuck.size(); ++i) {
    assign(message_.stuck_a[i], cycle.model, stuck[i].pair.a);
    assign(message_.stuck_b[i], cycle.model, stuck[i].pair.b);
    message_.stuck_distances[i] = stuck[i].distance;
    message_.stuck_rates[i] = stuck[i].rate;
  }
  message_.stuck = static_cast<std::uint32_t>(rows_.stuckCount());
}

}  // namespace proximity_server::node
