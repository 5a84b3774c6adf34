#pragma once

#include "node/monitor/slider_robot.h"
#include "node/record/recorder.h"
#include "scene/files.h"

#include <filesystem>
#include <set>

namespace proximity_server::node {

/// The sliders with a recorder in this process. The right sphere is in STOP at 0.21, and in CLEAR at 0.5.
class RecordedSliders : public MonitorOfSliders {
 protected:
  RecordedSliders() {
    ros::Time::init();
    config_.record_directory = files_.path("");
    config_.record_memory = 1.0;
  }

  void start() {
    follow("");
    recorder_.emplace(config_, "/cell/proximity_server");
    know();
  }
  void know() { recorder_->know({robot_, robot_->objects().get(), {}}); }
  /// Ends the record that is being written.
  Recorder::Outcome stop() {
    const bool is_wanted = recorder_->beginSaving();
    recorder_->stop();
    EXPECT_TRUE(is_wanted);
    return recorder_->outcome();
  }

  const Clearance& cycleAt(double right) {
    time_ += 0.02;
    PoseSnapshot snapshot = withTheRightSphereAt(*robot_, right);
    snapshot.stamp = ros::Time(time_);
    const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_, frames_);
    recorder_->add(*robot_, snapshot, frames_, clearance, settings_);
    return clearance;
  }

  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& file : std::filesystem::directory_iterator(files_.path(""))) names.insert(file.path().filename());
    return names;
  }

  scene::TemporaryFiles files_;
  std::optional<Recorder> recorder_;
  double time_ = 1000.0;
};

}  // namespace proximity_server::node
