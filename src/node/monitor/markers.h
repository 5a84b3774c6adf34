#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "node/robot/config.h"
#include "node/robot/robot.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_box.h"

namespace proximity_server::node {

/// The pieces that stand for the robot, each fixed in the frame of its link, see tfFrame(). Paddings are not drawn.
visualization_msgs::MarkerArray pieceMarkers(const scene::RobotModel& robot, const std::string& tf_prefix);

/// Draws the clearances of one robot, cycle by cycle:
///
/// "level"      a text above the robot in the colour of the level: the level, the closest pair and its distance. Where
///              it is INVALID the reason, and then there is nothing else.
/// "closest"    a thick line between the closest points of the closest pair, in the colour of the level.
/// "witnesses"  a line between those of every listed pair, coloured by the level that its distance alone would mean.
/// "distances"  labels of the next few pairs for which there is room.
/// "leaders"    thin lines from the text of the level to the closest pair, and from each label to its pair.
///
/// RViz draws a text behind what stands in front of it, so all texts stand above the box around the robot.
///
/// Every cycle has the same markers, with the same names and numbers; those that are not needed are taken away. All of
/// them vanish by themselves when no cycle follows.
class ClearanceMarkers {
 public:
  explicit ClearanceMarkers(const scene::RobotModel& robot);

  /// `poses` are those of the clearance, in its frame; where none is known the text stays where it was.
  visualization_msgs::MarkerArray draw(const Clearance& clearance, const scene::BodyPoses& poses,
                                       const MonitorSettings& settings);

 private:
  static constexpr std::size_t kLabels = 2;    // besides that of the closest pair, which the level's text tells
  static constexpr double kLabelHeight = 0.6;  // in heights of that text

  struct Drawing {
    const MonitorSettings& settings;
    std_msgs::ColorRGBA level_colour;
    visualization_msgs::Marker base;
    visualization_msgs::MarkerArray array;

    std_msgs::ColorRGBA colourOf(const Proximity& pair) const;
  };

  visualization_msgs::Marker base(const Clearance& clearance, const MonitorSettings& settings) const;
  void addSummary(const Clearance& clearance, Drawing& drawing) const;
  void addLines(const std::vector<const Proximity*>& pairs, Drawing& drawing) const;
  void addClosest(const std::vector<const Proximity*>& pairs, Drawing& drawing) const;
  void addLabels(const std::vector<const Proximity*>& pairs, Drawing& drawing) const;
  Eigen::Vector3d belowSummary() const;
  Eigen::Vector3d placeOfLabel(const Proximity& pair) const;
  std::vector<const Proximity*> pairsWithLabel(const std::vector<const Proximity*>& pairs) const;

  scene::RobotBox box_;
  Eigen::AlignedBox3d latest_box_;  ///< in the frame of the clearances; with all joints at 0 before there was a pose
  double text_height_;              ///< [m]
};

/// Markers that delete everything that was drawn.
visualization_msgs::MarkerArray noMarkers();

}  // namespace proximity_server::node
