#include "node/monitor/diagnostics.h"

#include "node/robot/level_name.h"

#include <algorithm>
#include <utility>

namespace proximity_server::node {
namespace {

using Level = diagnostic_msgs::DiagnosticStatus;

std::uint8_t severity(std::uint8_t level) {
  if (level == Clearance::CLEAR) return Level::OK;
  return level == Clearance::WARN ? Level::WARN : Level::ERROR;
}

bool isAboutTf(const QueryStatus& status) {
  return status.code <= QueryStatus::TF_UNAVAILABLE && status.code >= QueryStatus::TF_EXTRAPOLATION;
}

}  // namespace

Diagnostics::Diagnostics(const ros::NodeHandle& nh, TfPoses& tf, std::function<MonitorHealth()> health,
                         std::function<std::shared_ptr<const Robot>()> robot, std::function<Recorder::Outcome()> record,
                         std::function<std::string()> keeping)
    : tf_(tf),
      current_health_(std::move(health)),
      current_robot_(std::move(robot)),
      current_record_(std::move(record)),
      current_keeping_(std::move(keeping)) {
  updater_.setHardwareID(current_robot_()->robotModel().name);
  updater_.add("tf", this, &Diagnostics::reportTf);
  updater_.add("model", this, &Diagnostics::reportModel);
  updater_.add("clearance", this, &Diagnostics::reportClearance);
  updater_.add("timing", this, &Diagnostics::reportTiming);
  updater_.add("record", this, &Diagnostics::reportRecord);
  updater_.add("objects", this, &Diagnostics::reportObjects);
  timer_ = nh.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { update(); });
}

void Diagnostics::update() {
  cycles_before_ = health_.last.cycle;
  health_ = current_health_();
  robot_ = current_robot_();
  updater_.force_update();
}

void Diagnostics::reportTf(Status& status) {
  const Clearance& last = health_.last;
  const double max_skew = robot_->config().max_tf_skew;
  if (last.cycle == 0) {
    status.summary(Level::WARN, "not looked at yet");
  } else if (isAboutTf(last.status)) {
    status.summary(Level::ERROR, last.status.message);
  } else if (last.tf_skew.toSec() > max_skew) {
    status.summary(Level::WARN, "the transforms are further apart in time than max_tf_skew");
  } else {
    status.summary(Level::OK, "complete and fresh");
  }
  for (const std::string& warning : tf_.warnings(*robot_, health_.settings.rate))
    status.mergeSummary(Level::WARN, warning);
  reportJumps(status);
  status.add("age [s]", last.tf_age.toSec());
  status.add("skew [s]", last.tf_skew.toSec());
}

void Diagnostics::reportJumps(Status& status) {
  const std::vector<std::string> jumps = tf_.jumps();
  if (jumps.empty()) return;
  const std::string more = jumps.size() > 1 ? " (and " + std::to_string(jumps.size() - 1) + " more)" : "";
  status.mergeSummary(Level::WARN, jumps.front() + more);
  for (const std::string& jump : jumps) status.add("jumps", jump);
}

void Diagnostics::reportModel(Status& status) {
  const scene::SceneModel& model = robot_->sceneModel();
  const std::size_t warnings = model.robot.warnings.size() + model.pairs.warnings.size();
  if (warnings > 0) {
    status.summaryf(Level::OK, "loaded with %zu warnings: see model_info", warnings);
  } else {
    status.summary(Level::OK, "loaded");
  }
  status.add("robot", model.robot.name);
  status.add("convex pieces", model.robot.pieces.size());
  status.add("pairs", model.pairs.pairs.size());
  status.add("pairs checked", model.pairs.checked.size());
  const std::shared_ptr<const scene::Objects> objects = robot_->objects().get().all;
  status.add("objects", objects->size());
  status.add("pairs checked with objects", objects->pairCount());
}

void Diagnostics::reportClearance(Status& status) {
  const Clearance& last = health_.last;
  if (!health_.enabled) {
    status.summary(Level::WARN, "the monitor is disabled");
    return;
  }
  const std::string reason = last.status.message.empty() ? "" : ": " + last.status.message;
  const std::uint8_t least = health_.broken.empty() && health_.beyond.empty() ? Level::OK : Level::WARN;
  status.summary(std::max(severity(last.level), least), std::string(levelName(last.level)) + reason);
  if (!health_.broken.empty()) status.add("joint inequality", health_.broken);
  if (!health_.beyond.empty()) status.add("joint_states", health_.beyond);
  status.add("distance [m]", last.minimum.distance);
  status.add("between", last.minimum.a.link + " and " + last.minimum.b.link);
  status.add("level set by", last.deciding.a.link + " and " + last.deciding.b.link);
  status.add("at the distance [m]", last.deciding.distance);
  if (last.by_guaranteed) status.add("guaranteed to be [m]", last.deciding.guaranteed);
  status.add(std::string("their threshold of ") + levelOfThreshold(last.level) + " [m]", last.deciding_threshold);
  status.add("pairs below threshold", last.pairs_below_threshold);
}

void Diagnostics::reportTiming(Status& status) {
  const double period = health_.settings.rate > 0.0 ? 1.0 / health_.settings.rate : 0.0;
  const std::uint64_t cycles = health_.last.cycle - cycles_before_;
  if (!health_.enabled) {
    status.summary(Level::OK, "the monitor is disabled");
  } else if (cycles == 0) {
    status.summary(Level::ERROR, "no cycle since the last report");
  } else if (period > 0.0 && health_.slowest_cycle.toSec() > period) {
    status.summary(Level::WARN, "a cycle took longer than the period of the rate");
  } else {
    status.summary(Level::OK, "in time");
  }
  status.add("cycles since the last report", cycles);
  status.add("slowest of them [s]", health_.slowest_cycle.toSec());
}

void Diagnostics::reportRecord(Status& status) {
  const Recorder::Outcome record = current_record_();
  if (!record.problem.empty())
    status.summary(Level::ERROR, record.problem);
  else
    status.summary(Level::OK, record.file.empty() ? "no record yet" : "recorded");
  status.add("latest record", record.file);
  status.add("cycles lost by a slow disk", record.lost);
}

void Diagnostics::reportObjects(Status& status) {
  const std::string problem = current_keeping_(), &file = robot_->config().objects_file;
  if (!problem.empty())
    status.summary(Level::ERROR, "not kept for the next start: " + problem);
  else
    status.summary(Level::OK, file.empty() ? "objects_file keeps none" : "kept for the next start");
  status.add("file", file);
}

}  // namespace proximity_server::node
