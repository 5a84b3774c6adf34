#pragma once

#include "node/answers/gradients.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/scene/answers/assessment.h"

#include <ros/time.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// Writes the sentence of QueryStatus::message about the pair that sets the level: "forearm is 12.3 mm from table,
/// closing 80 mm/s by elbow; stop below 20 mm".
///
/// The velocity of a joint is the difference of its positions in two cycles, divided by the difference of their stamps,
/// because joint_states need not have velocities. A joint closes the gap at -gradient . velocity; at most two are
/// named. The rate is the sum over all joints, so it lacks what tf frames of objects and bases contribute.
class ClearanceText {
 public:
  /// The robot must outlive it.
  explicit ClearanceText(const scene::RobotModel& robot)
      : robot_(robot), columns_(scene::DegreesOfFreedom(robot).list()) {}

  /// Takes the poses of this cycle.
  void move(const scene::BodyPoses& poses, const ros::Time& stamp);

  /// Writes about a clearance that is not INVALID. `gradient` belongs to its deciding pair; empty: the motion is
  /// not told.
  /// Allocates nothing if the text has a capacity of capacity().
  void write(std::string& text, const Clearance& clearance, const std::vector<double>& gradient) const;

  /// Appends: "; '2*j1 - j2 <= 1.7' is broken by 0.2".
  static void append(std::string& text, const scene::BrokenInequality& broken);

  /// [characters] The longest text about links and objects whose names have at most `longest_name` characters, with
  /// that about a JointBeyond.
  std::size_t capacity(std::size_t longest_name) const;

 private:
  double velocityOf(const scene::DegreeOfFreedom& column) const;
  void writeMotion(std::string& text, const std::vector<double>& gradient) const;

  const scene::RobotModel& robot_;
  const std::vector<scene::DegreeOfFreedom> columns_;
  scene::BodyPoses before_, poses_;  ///< in the latest two cycles with different stamps
  ros::Time stamp_;                  ///< of poses_
  double elapsed_ = 0.0;             ///< [s] between the two; 0: there are no two
};

}  // namespace proximity_server::node
