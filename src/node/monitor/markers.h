#pragma once

#include "node/robot/config.h"
#include "node/robot/robot.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_box.h"

#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// Draws the convex pieces that the queries use, each fixed in the frame of its link. Paddings are not drawn.
visualization_msgs::MarkerArray pieceMarkers(const Robot& robot);

/// Draws the clearances of one robot. Every cycle has these markers, by namespace:
///
/// "level"      a text above the robot in the colour of the level: the level and the message of the status. If the
///              level is INVALID, nothing else is drawn.
/// "deciding"   a thick line between the closest points of that pair, in the colour of the level.
/// "witnesses"  a line between the closest points of every listed pair, in the colour of its own level.
/// "distances"  labels with the distances of the next few pairs for which there is room.
/// "leaders"    thin lines from the text of the level to the pair that sets it, and from each label to its pair.
///
/// RViz hides a text behind the shapes in front of it, so all texts are placed above the bounding box of the robot.
///
/// Every cycle has the same markers, with the same namespaces and ids; a marker that is not needed has the action
/// DELETE. All markers have a lifetime, so that they disappear when no cycle follows.
class ClearanceMarkers {
 public:
  explicit ClearanceMarkers(const scene::RobotModel& robot);

  /// Draws a clearance. `poses` are those of the clearance, in its frame. If no pose is known, the text stays where it
  /// was.
  visualization_msgs::MarkerArray draw(const Clearance& clearance, const scene::BodyPoses& poses,
                                       const MonitorSettings& settings);

 private:
  static constexpr std::size_t kLabels = 2;    // without the deciding pair, which the level's text is about
  static constexpr double kLabelHeight = 0.6;  // relative to the height of the level's text

  /// A pair that is drawn. The first one in a list is the pair that sets the level.
  struct DrawnPair {
    const Proximity* pair;
    std_msgs::ColorRGBA colour;  ///< the colour of the pair's level
  };
  struct Drawing {
    std_msgs::ColorRGBA level_colour;
    visualization_msgs::Marker base;
    visualization_msgs::MarkerArray array;
  };

  visualization_msgs::Marker base(const Clearance& clearance, const MonitorSettings& settings) const;
  void addSummary(const Clearance& clearance, Drawing& drawing) const;
  static std::vector<DrawnPair> pairsOf(const Clearance& clearance);
  void addLines(const std::vector<DrawnPair>& pairs, Drawing& drawing) const;
  void addDeciding(const std::vector<DrawnPair>& pairs, Drawing& drawing) const;
  void addLabels(const std::vector<DrawnPair>& pairs, Drawing& drawing) const;
  Eigen::Vector3d belowSummary() const;
  Eigen::Vector3d placeOfLabel(const Proximity& pair) const;
  std::vector<DrawnPair> pairsWithLabel(const std::vector<DrawnPair>& pairs) const;

  scene::RobotBox box_;
  Eigen::AlignedBox3d latest_box_;  ///< in the frame of the clearances; at first, with all joints at 0
  double text_height_;              ///< [m]
};

/// Adds the balls of each tracked source, as "tracked", to what ClearanceMarkers::draw() has drawn.
void addTracked(const Robot& robot, const scene::Objects& objects, visualization_msgs::MarkerArray& array);

geometry_msgs::Point point(const Eigen::Vector3d& vector);
void setSize(visualization_msgs::Marker& marker, const Eigen::Vector3d& size);

/// A marker that deletes everything that was drawn.
visualization_msgs::MarkerArray noMarkers();

}  // namespace proximity_server::node
