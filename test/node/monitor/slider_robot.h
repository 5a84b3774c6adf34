#pragma once

#include "node/monitor/monitor.h"
#include "robots/urdf.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::node {

/// Three spheres on sliders along x, with a radius of 0.1 m. No two of them are neighbours.
inline const std::string kSliders =
    robots::onRail({{"left", robots::ball("0.1")}, {"middle", robots::ball("0.1")}, {"right", robots::ball("0.1")}});

/// A snapshot with the status OK: left at x = -1, middle at 0, right at `x` [m].
inline PoseSnapshot withTheRightSphereAt(const Robot& robot, double x) {
  PoseSnapshot snapshot;
  snapshot.stamp = ros::Time(1000.0);
  snapshot.poses = scene::forwardKinematics(robot.robotModel(), std::vector<double>{-1.0, 0.0, x});
  return snapshot;
}

/// A ball of radius 0.1 m.
inline scene::Object ballAt(const scene::Placement& placement, const std::string& id = "ball") {
  return scene::makeObject(id, {{narrowphase::Shape(narrowphase::Sphere{0.1})}}, placement);
}
inline scene::Fixed standingAt(double x, double y, double z) {
  return {Eigen::Isometry3d(Eigen::Translation3d(x, y, z))};
}

/// A monitor of the sliders and their objects in this process.
class MonitorOfSliders : public testing::Test {
 protected:
  /// No clock ends the guaranteed distances, which are compared.
  MonitorOfSliders() { monitor_.endTimeAfter(std::numeric_limits<std::int64_t>::max()); }

  void follow(const std::string& srdf) {
    robot_ = std::make_shared<const Robot>(kSliders, srdf, config_);
    monitor_.follow(robot_);
  }
  void add(const scene::Object& object) {
    const RobotObjects before = robot_->objects().get();
    robot_->objects().set(
        {std::make_shared<const scene::Objects>(before.all->changed({scene::AddObject{object}})), before.revision + 1});
    MonitoredObjects objects(*robot_, robot_->objects().get());
    monitor_.use(objects);
  }
  const Clearance& cycleWithTheRightSphereAt(double x) {
    return monitor_.cycle(withTheRightSphereAt(*robot_, x), {}, MonitorSettings());
  }

  /// With the right sphere at 0.5, and these poses of frames.
  const Clearance& cycle(const scene::FramePoses& poses = {}) {
    frames_.poses = poses;
    return monitor_.cycle(snapshot(), {}, settings_, frames_);
  }
  PoseSnapshot snapshot() const { return withTheRightSphereAt(*robot_, 0.5); }

  Config config_;
  std::shared_ptr<const Robot> robot_;
  Monitor monitor_;
  MonitorSettings settings_;
  FrameSnapshot frames_;
};

}  // namespace proximity_server::node
