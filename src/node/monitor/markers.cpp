#include "node/monitor/markers.h"

#include "node/objects/change_fields.h"
#include "node/robot/level_colour.h"
#include "node/robot/level_name.h"
#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace proximity_server::node {
geometry_msgs::Point point(const Eigen::Vector3d& vector) {
  geometry_msgs::Point result;
  result.x = vector.x();
  result.y = vector.y();
  result.z = vector.z();
  return result;
}

void setSize(visualization_msgs::Marker& marker, const Eigen::Vector3d& size) {
  marker.scale.x = size.x();
  marker.scale.y = size.y();
  marker.scale.z = size.z();
}

namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

std_msgs::ColorRGBA colour(float r, float g, float b, float a) {
  std_msgs::ColorRGBA result;
  result.r = r;
  result.g = g;
  result.b = b;
  result.a = a;
  return result;
}

/// Appends the markers of one piece to an array.
class PieceDrawing {
 public:
  PieceDrawing(const Robot& robot, const scene::Piece& piece, MarkerArray& array) : shape_(piece.shape), array_(array) {
    const scene::Collision& collision = robot.robotModel().collisions[piece.collision];
    link_T_piece_ = robot.robotModel().links[collision.link].body_T_link.inverse() * piece.body_T_piece;
    base_.header.frame_id = robot.frameOf(collision.link);
    base_.ns = collision.is_visual ? "pieces_from_visual" : "pieces";
    base_.frame_locked = true;
    base_.color = colour(0.3f, 0.5f, 0.9f, 0.35f);
  }

  void draw() {
    const Eigen::Vector3d size = 2.0 * shape_.halfExtents();
    const Eigen::Vector3d ball = Eigen::Vector3d::Constant(2.0 * shape_.margin());
    switch (shape_.kind()) {
      case narrowphase::Shape::Kind::Point:
        return add(Marker::SPHERE, ball);
      case narrowphase::Shape::Kind::Segment:
        add(Marker::CYLINDER, {ball.x(), ball.y(), size.z()});
        add(Marker::SPHERE, ball, 0.5 * size.z());
        return add(Marker::SPHERE, ball, -0.5 * size.z());
      case narrowphase::Shape::Kind::Box:
        return add(Marker::CUBE, size);
      case narrowphase::Shape::Kind::Cylinder:
        return add(Marker::CYLINDER, size);
      case narrowphase::Shape::Kind::Ellipsoid:
        return add(Marker::SPHERE, size);
      case narrowphase::Shape::Kind::Hull:
        return addTriangles();
      case narrowphase::Shape::Kind::Cone:
      case narrowphase::Shape::Kind::Sweep:
        return;  // a URDF cannot have these shapes, and RViz has no markers for them
    }
  }

 private:
  /// Appends a marker whose centre lies at `height` [m] on the piece's z axis.
  void add(int type, const Eigen::Vector3d& size, double height = 0.0) {
    Marker marker = base_;
    marker.type = type;
    marker.id = static_cast<int>(array_.markers.size());
    marker.pose = toMessage(link_T_piece_ * Eigen::Translation3d(0.0, 0.0, height));
    setSize(marker, size);
    array_.markers.push_back(std::move(marker));
  }

  void addTriangles() {
    add(Marker::TRIANGLE_LIST, Eigen::Vector3d::Ones());
    Marker& marker = array_.markers.back();
    for (const auto& triangle : shape_.hull().triangles()) {
      for (const int vertex : triangle) {
        marker.points.push_back(point(shape_.hull().vertices()[vertex]));
      }
    }
    if (marker.points.empty()) array_.markers.pop_back();
  }

  const narrowphase::Shape& shape_;
  MarkerArray& array_;
  Eigen::Isometry3d link_T_piece_;
  Marker base_;
};

/// Formats a distance: "12.3 mm", or for an overlap "9.4 mm deep". A minus sign is hard to see in small texts of RViz.
std::string millimetres(double distance) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm%s", 1000.0 * std::abs(distance), distance < 0.0 ? " deep" : "");
  return text;
}

/// Breaks the text between words into lines of about this many characters.
std::string inLines(const std::string& text, std::size_t characters) {
  std::string result = text;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (result[i] != ' ' || i - begin < characters) continue;
    result[i] = '\n';
    begin = i + 1;
  }
  return result;
}

bool isSame(const ShapeRef& p, const ShapeRef& q) { return p.kind == q.kind && p.robot == q.robot && p.link == q.link; }
bool areSame(const Proximity& p, const Proximity& q) { return isSame(p.a, q.a) && isSame(p.b, q.b); }

/// A marker for lines of this width [m].
Marker linesOf(const Marker& base, const std::string& name_space, double width) {
  Marker lines = base;
  lines.ns = name_space;
  lines.type = Marker::LINE_LIST;
  lines.scale.x = width;
  return lines;
}

void addLine(Marker& lines, const geometry_msgs::Point& from, const geometry_msgs::Point& to,
             const std_msgs::ColorRGBA& line_colour) {
  lines.points.insert(lines.points.end(), {from, to});
  lines.colors.insert(lines.colors.end(), 2, line_colour);
}

/// Appends a marker with lines. If it has no lines, it deletes those of the last cycle.
void append(Marker lines, MarkerArray& array) {
  if (lines.points.empty()) lines.action = Marker::DELETE;
  array.markers.push_back(std::move(lines));
}

Vector3d middleOf(const Proximity& pair) {
  return 0.5 *
         Vector3d(pair.point_a.x + pair.point_b.x, pair.point_a.y + pair.point_b.y, pair.point_a.z + pair.point_b.z);
}

}  // namespace

MarkerArray pieceMarkers(const Robot& robot) {
  const scene::RobotModel& model = robot.robotModel();
  MarkerArray array;
  for (const scene::Body& body : model.bodies) {
    for (const int piece : body.pieces) PieceDrawing(robot, model.pieces[piece], array).draw();
  }
  return array;
}

void addTracked(const Robot& robot, const scene::Objects& objects, MarkerArray& array) {
  int id = 0;
  for (const TrackedSource& source : robot.config().tracked) {
    if (source.sensing) continue;  // ~sensed_points shows what it sees
    Marker balls;
    balls.header = array.markers.front().header;
    balls.lifetime = array.markers.front().lifetime;
    balls.ns = "tracked";
    balls.id = id++;
    balls.type = Marker::SPHERE_LIST;
    balls.pose.orientation.w = 1.0;
    balls.color = colour(1.0f, 0.6f, 0.1f, 0.5f);
    setSize(balls, Vector3d::Constant(2.0 * source.radius));
    if (const scene::Object* object = objects.object(objects.find(source.name)))
      for (const scene::Piece& piece : scene::piecesOf(*object))
        balls.points.push_back(
            point((std::get<scene::Fixed>(object->placement).world_T_object * piece.body_T_piece).translation()));
    append(std::move(balls), array);
  }
}

ClearanceMarkers::ClearanceMarkers(const scene::RobotModel& robot) : box_(robot) {
  const AlignedBox3d at_zero = box_.at(scene::forwardKinematics(robot, std::vector<double>(robot.joints.size(), 0.0)));
  latest_box_ = at_zero.isEmpty() ? AlignedBox3d(Vector3d::Zero()) : at_zero;
  constexpr double kRelativeTextHeight = 0.035;  // just readable when the robot fills the view
  text_height_ = std::max(0.01, kRelativeTextHeight * latest_box_.sizes().norm());
}

MarkerArray ClearanceMarkers::draw(const Clearance& clearance, const scene::BodyPoses& poses,
                                   const MonitorSettings& settings) {
  if (const AlignedBox3d box = box_.at(poses); !box.isEmpty()) latest_box_ = box;
  Drawing drawing{levelColour(clearance.level), base(clearance, settings), {}};
  const std::vector<DrawnPair> pairs = pairsOf(clearance);
  addSummary(clearance, drawing);
  addLines(pairs, drawing);
  addDeciding(pairs, drawing);
  addLabels(pairs, drawing);
  return drawing.array;
}

/// The deciding pair, and behind it the listed pairs, the closest one first.
std::vector<ClearanceMarkers::DrawnPair> ClearanceMarkers::pairsOf(const Clearance& clearance) {
  std::vector<DrawnPair> pairs;
  if (clearance.level == Clearance::INVALID) return pairs;
  const auto add = [&](const Proximity& pair, std::uint8_t level) {
    if (pair.points_valid) pairs.push_back({&pair, levelColour(level)});
  };
  add(clearance.deciding, clearance.level);
  for (std::size_t i = 0; i < clearance.below_threshold.size(); ++i)
    if (!areSame(clearance.below_threshold[i], clearance.deciding))
      add(clearance.below_threshold[i], clearance.levels[i]);
  return pairs;
}

/// A marker with the fields that all markers of a cycle share.
Marker ClearanceMarkers::base(const Clearance& clearance, const MonitorSettings& settings) const {
  constexpr double kMinLifetime = 3.0;  // [s]; a running monitor publishes at least once per second
  Marker marker;
  marker.header = clearance.header;
  // The stamp 0 lets RViz place the text by the latest transforms that it has, because current ones are missing.
  if (clearance.level == Clearance::INVALID) marker.header.stamp = ros::Time();
  marker.pose.orientation.w = 1.0;
  marker.lifetime = ros::Duration(settings.rate > 0.0 ? std::max(kMinLifetime, 3.0 / settings.rate) : kMinLifetime);
  return marker;
}

void ClearanceMarkers::addSummary(const Clearance& clearance, Drawing& drawing) const {
  Marker marker = drawing.base;
  marker.ns = "level";
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.text = std::string(levelName(clearance.level)) + "\n" + inLines(clearance.status.message, 40);
  marker.color = drawing.level_colour;
  marker.scale.z = text_height_;
  // RViz centres a text, and its lines are about 1.2 heights apart.
  const auto lines = static_cast<double>(1 + std::count(marker.text.begin(), marker.text.end(), '\n'));
  const Vector3d half_height(0.0, 0.0, (0.6 * lines + 0.25) * text_height_);
  marker.pose.position = point(belowSummary() + half_height);
  drawing.array.markers.push_back(std::move(marker));
}

void ClearanceMarkers::addLines(const std::vector<DrawnPair>& pairs, Drawing& drawing) const {
  Marker lines = linesOf(drawing.base, "witnesses", 0.06 * text_height_);
  for (const DrawnPair& drawn : pairs) addLine(lines, drawn.pair->point_a, drawn.pair->point_b, drawn.colour);
  append(std::move(lines), drawing.array);
}

void ClearanceMarkers::addDeciding(const std::vector<DrawnPair>& pairs, Drawing& drawing) const {
  Marker line = linesOf(drawing.base, "deciding", 0.15 * text_height_);
  line.color = drawing.level_colour;
  if (!pairs.empty()) line.points = {pairs.front().pair->point_a, pairs.front().pair->point_b};
  append(std::move(line), drawing.array);
}

void ClearanceMarkers::addLabels(const std::vector<DrawnPair>& pairs, Drawing& drawing) const {
  Marker leaders = linesOf(drawing.base, "leaders", 0.03 * text_height_);
  const auto add_leader = [&](const Proximity& pair, const Vector3d& place, const std_msgs::ColorRGBA& pair_colour) {
    addLine(leaders, point(middleOf(pair)), point(place), pair_colour);
  };
  if (!pairs.empty()) add_leader(*pairs.front().pair, belowSummary(), drawing.level_colour);
  const std::vector<DrawnPair> labelled = pairsWithLabel(pairs);
  for (std::size_t i = 0; i < kLabels; ++i) {
    Marker label = drawing.base;
    label.ns = "distances";
    label.id = static_cast<int>(i);
    label.type = Marker::TEXT_VIEW_FACING;
    if (i < labelled.size()) {
      const Proximity& pair = *labelled[i].pair;
      label.text = millimetres(pair.distance);
      label.color = labelled[i].colour;
      label.scale.z = kLabelHeight * text_height_;
      label.pose.position = point(placeOfLabel(pair));
      add_leader(pair, placeOfLabel(pair) - Vector3d(0.0, 0.0, 0.6 * label.scale.z), label.color);
    } else {
      label.action = Marker::DELETE;
    }
    drawing.array.markers.push_back(std::move(label));
  }
  append(std::move(leaders), drawing.array);
}

/// The point below the level's text, and above the labels, where the line to the deciding pair begins.
Vector3d ClearanceMarkers::belowSummary() const {
  const Vector3d centre = latest_box_.center();
  return {centre.x(), centre.y(), latest_box_.max().z() + 3.0 * text_height_};
}

/// The position of a label. It is above the robot, so that in a view from the side no shape is in front of it or behind
/// it. It is somewhat closer to the middle of the robot than its pair, because a label that is closer to a viewer who
/// looks down appears lower.
Vector3d ClearanceMarkers::placeOfLabel(const Proximity& pair) const {
  const Vector3d place = 0.7 * middleOf(pair) + 0.3 * latest_box_.center();
  return {place.x(), place.y(), latest_box_.max().z() + 1.6 * text_height_};
}

/// The pairs with a label. The first pair never has one. The labels overlap neither each other nor the line from the
/// first pair to the level's text, and their own lines are not too close to that line.
std::vector<ClearanceMarkers::DrawnPair> ClearanceMarkers::pairsWithLabel(const std::vector<DrawnPair>& pairs) const {
  const double width = 5.0 * kLabelHeight * text_height_;  // the width of "123.4 mm"
  std::vector<DrawnPair> labelled;
  for (std::size_t i = 1; i < pairs.size() && labelled.size() < kLabels; ++i) {
    const Proximity& pair = *pairs[i].pair;
    const Vector3d place = placeOfLabel(pair), first = middleOf(*pairs.front().pair), top = belowSummary();
    const Vector3d line = top + (place.z() - top.z()) / (first.z() - top.z()) * (first - top);
    const auto is_near = [&](const DrawnPair& other) { return (place - placeOfLabel(*other.pair)).norm() < width; };
    if ((place - line).norm() > 0.6 * width && (middleOf(pair) - first).norm() > width &&
        std::none_of(labelled.begin(), labelled.end(), is_near))
      labelled.push_back(pairs[i]);
  }
  return labelled;
}

MarkerArray noMarkers() {
  MarkerArray array;
  array.markers.resize(1);
  array.markers.front().action = Marker::DELETEALL;
  return array;
}

}  // namespace proximity_server::node
