#pragma once

#include "node/answers/gradients.h"
#include "proximity_server/Clearance.h"

#include <ros/time.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// Writes the sentence of QueryStatus::message about the pair that sets the level: "forearm is 12.3 mm from table,
/// closing 80 mm/s by elbow; stop below 20 mm".
///
/// The velocity of a joint is the difference of its positions in two cycles, divided by that of their stamps, because
/// joint_states need not have velocities. A joint closes the gap at -gradient . velocity; at most two are named. The
/// rate is the sum over all joints, so it lacks what tf frames of objects and bases contribute.
class ClearanceText {
 public:
  /// For a robot with these columns.
  explicit ClearanceText(const scene::DegreesOfFreedom& columns) : columns_(columns.list()) {}

  /// Takes the positions of the columns in this cycle, see Gradients::assignPositions().
  void move(const std::vector<double>& positions, const ros::Time& stamp);

  /// Writes about a clearance that is not INVALID. `gradient` is that of its deciding pair; empty if it is not known.
  /// Allocates nothing if the text has a capacity of capacity().
  void write(std::string& text, const Clearance& clearance, const std::vector<double>& gradient) const;

  /// [characters] The longest text about links and objects whose names have at most `longest_name` characters.
  std::size_t capacity(std::size_t longest_name) const;

 private:
  void writeMotion(std::string& text, const std::vector<double>& gradient) const;

  std::vector<scene::DegreeOfFreedom> columns_;
  std::vector<double> positions_;   ///< in the latest cycle
  std::vector<double> velocities_;  ///< [rad/s] or [m/s]; NaN if unknown
  ros::Time stamp_;                 ///< of positions_
};

}  // namespace proximity_server::node
