#pragma once

#include "proximity_server/scene/motion/joint_spline.h"
#include "python/joint_positions.h"

#include <pybind11/numpy.h>
#include <Eigen/Core>

#include <vector>

namespace proximity_server::python {

/// How the joints move along edges, as keywords say it; None: not given.
struct EdgeMotion {
  pybind11::object velocities, accelerations;  ///< a pair: at the start and at the goal; by second
  pybind11::object duration;                   ///< [s] a number, or one for each edge
  pybind11::object tracking_error;             ///< [rad] or [m] a number, or one for each joint
};

/// The edges of a question, and the motions along them.
class DrivenEdges {
 public:
  /// Failure: throws as jointArray() and JointPositions::broadcast(). Throws std::invalid_argument naming the keyword for accelerations
  ///          without velocities, for what is not a pair, for a duration that is not positive, and for negative or too
  ///          many tracking errors.
  DrivenEdges(const pybind11::object& start, const pybind11::object& goal, const EdgeMotion& motion,
              const scene::RobotModel& robot);

  const JointPositions& start() const { return arrays_.front(); }

  /// False: every joint moves at constant velocity, exactly.
  bool areSplines() const { return has_velocities_ || !tracking_error_.empty(); }
  /// For each joint; empty: none.
  const std::vector<double>& trackingError() const { return tracking_error_; }

  /// An edge; the times are 0 and the duration.
  struct Edge {
    scene::TrajectoryPoint start, goal;
    bool is_finite;  ///< False if a number is not, or the difference of two
  };
  /// Does not need the GIL.
  Edge at(Eigen::Index edge) const;

 private:
  std::vector<JointPositions> arrays_;  ///< start, goal, duration, velocities and accelerations at both ends
  bool has_velocities_, has_accelerations_;
  std::vector<double> tracking_error_;
};

}  // namespace proximity_server::python
