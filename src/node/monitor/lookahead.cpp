#include "node/monitor/lookahead.h"

#include "node/answers/conversions.h"
#include "node/answers/motions.h"
#include "node/answers/statuses.h"
#include "node/robot/query_status.h"
#include "system/durations.h"

#include <cmath>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

/// Tells that moving objects are assumed to rest, unless it is known that they do; "" for none.
std::string restingText(const LookaheadStart& start) {
  if (start.may_move.empty()) return {};
  return "objects in frame '" + start.frames.names[start.may_move.front()] + "' are taken to rest where they are";
}

/// Tells which inequality is broken first, and when; and the turns that are assumed. "" for none.
std::string textOfLimits(const scene::RobotModel& robot, const LookaheadStart& start, const scene::ContactAhead& ahead,
                         double duration) {
  if (!ahead.is_along_splines) return limitsText(robot, start.state.poses(), start.stated, ahead.limits, duration);
  std::string text;
  if (ahead.broken_spline)
    text = "after " + system::secondsText(ahead.broken_spline->time) + " " +
           ahead.broken_spline->inequality->brokenText(ahead.broken_spline->excess);
  return joined(text, assumedText(robot, ahead.limits));
}

QueryStatus statusAhead(const scene::ContactAhead& ahead, const CommandedMotion& commanded) {
  if (ahead.motions > scene::Lookahead::kMostMotions)
    return statusOf(QueryStatus::OVER_BUDGET, "joints may follow their trajectories in more than " +
                                                  std::to_string(scene::Lookahead::kMostMotions) +
                                                  " ways: " + commanded.text);
  if (!ahead.problem.empty()) return statusOf(QueryStatus::NO_VELOCITY, ahead.problem);
  const QueryStatus status = completeness(ahead.found.counts);
  return status.code == QueryStatus::OK ? statusOfContact(ahead.found, ahead.time_free, ahead.question) : status;
}

}  // namespace

Lookahead noLookahead(const MonitorSettings& settings) {
  Lookahead result;
  result.state = settings.lookahead > 0.0 ? Lookahead::UNKNOWN : Lookahead::OFF;
  result.lookahead = settings.lookahead;
  result.contact_distance = settings.stop_distance;
  result.object_contact_distance = settings.object_stop_distance;
  result.time_free = result.time_to_contact = result.pair_contact_distance = kNaN;
  result.pair = unknownProximity();
  return result;
}

double searchTime(const MonitorSettings& settings) { return settings.rate > 0.0 ? 0.25 / settings.rate : 0.0025; }

std::chrono::steady_clock::time_point searchDeadline(const MonitorSettings& settings) {
  return system::deadlineIn(searchTime(settings));
}

void assign(scene::LookaheadQuestion& question, const Robot& robot, scene::MotionSearch& search,
            const LookaheadStart& start, const VelocitySnapshot& velocities, const CommandedMotion& commanded,
            const MonitorSettings& settings) {
  question.search = &search;
  question.duration = settings.lookahead;
  question.most_search_time = searchTime(settings);
  question.start = start.state.poses();
  question.start = inRoot(robot, std::move(question.start));
  question.frames = objectFramesInRoot(robot, start.state.poses(), start.frames, start.state.frames());
  question.velocities = velocities.velocities;
  question.commanded = &commanded;
}

void assign(Lookahead& message, const scene::ContactAhead& ahead, const Robot& robot, const LookaheadStart& start,
            const CommandedMotion& commanded, const MonitorSettings& settings) {
  std::string text = std::move(message.status.message);  // keeps its memory
  message = noLookahead(settings);
  message.status = statusAhead(ahead, commanded);
  if (std::isnan(ahead.time_free)) return;
  assignStops(message, robot, ahead.limits, settings.lookahead);
  message.time_free = ahead.time_free;
  if (ahead.found.contact) {
    message.state = Lookahead::CONTACT;
    message.time_to_contact = ahead.time_to_contact;
    message.pair_contact_distance = ahead.question.thresholds->of(ahead.found.pair.asked);
    message.pair = toMessage({robot.robotModel(), start.state.objects().get()}, ahead.motion, ahead.found.t_contact,
                             ahead.found.state, ahead.found.pair);
  } else if (message.status.code == QueryStatus::OK) {
    message.state = Lookahead::FREE;
  }
  if (message.status.code != QueryStatus::OK) return;
  const std::string assumed =
      joined(restingText(start), textOfLimits(robot.robotModel(), start, ahead, settings.lookahead));
  text = commanded.text;
  message.status.message = assumed.empty() ? std::move(text) : joined(assumed, text);
}

}  // namespace proximity_server::node
