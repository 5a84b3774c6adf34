#include "proximity_server/scene/motion/motion.h"

#include <functional>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;

Positions difference(const Positions& from, const Positions& to) {
  Positions travel(to.size());
  std::transform(to.begin(), to.end(), from.begin(), travel.begin(), std::minus<>());
  return travel;
}

/// Returns a part of a motion, beginning at the time `begin`. The velocity of the origin at that time belongs to the
/// same screw.
RobotMotion::Segment during(double begin, double end, RobotMotion::Segment segment) {
  narrowphase::ScrewMotion& motion = segment.motion;
  if (!segment.is_known || motion.isRest()) return segment;
  const Isometry3d start = motion.at(begin);
  const Eigen::Vector3d velocity =
      motion.linear + motion.angular.cross(start.translation() - motion.start.translation());
  motion = {start, (end - begin) * velocity, (end - begin) * motion.angular};
  return segment;
}

/// A motion of one piece along a spline that begins with these poses.
Motion::Piece along(const RobotModel& model, const BodyPoses& start, SplineSegment spline,
                    std::vector<double> tracking_error) {
  Positions from = spline.at(0.0);
  auto rest = RobotMotion::ofTravel(model, start, std::vector<double>(from.size()));
  return {0.0, 1.0, std::move(rest), std::move(from), {}, std::move(spline), std::move(tracking_error)};
}

}  // namespace

Motion::Motion(RobotMotion motion) : pieces_{{0.0, 1.0, std::move(motion)}} {}

Motion::Motion(std::vector<Piece> pieces) : pieces_(std::move(pieces)) {
  double time = 0.0;
  for (const Piece& piece : pieces_) {
    if (piece.begin != time || !(piece.end > piece.begin))
      throw std::invalid_argument("the pieces of a motion do not follow each other");
    time = piece.end;
  }
  if (time != 1.0) throw std::invalid_argument("the pieces of a motion do not end at 1");
}

Motion::Motion(const RobotModel& model, const BodyPoses& start, const TrajectoryPoint& from, const TrajectoryPoint& to,
               const std::vector<double>& tracking_error)
    : begin_(from.time), end_(to.time) {
  const bool is_straight = (from.velocities.empty() || to.velocities.empty()) &&
                           std::all_of(tracking_error.begin(), tracking_error.end(), [](double e) { return e == 0.0; });
  if (is_straight)
    pieces_.push_back({0.0, 1.0, RobotMotion::ofTravel(model, start, difference(from.positions, to.positions)),
                       from.positions, to.positions});
  else
    pieces_.push_back(along(model, start, SplineSegment(model, from, to), tracking_error));
}

Motion::Motion(const RobotModel& model, const TrajectoryPoint& from, const TrajectoryPoint& to,
               const std::vector<double>& tracking_error)
    : Motion(model, forwardKinematics(model, from.positions), from, to, tracking_error) {}

Motion::Motion(const RobotModel& model, SplineSegment spline, std::vector<double> tracking_error)
    : begin_(spline.begin()), end_(spline.end()) {
  const BodyPoses start = forwardKinematics(model, spline.at(0.0));
  pieces_.push_back(along(model, start, std::move(spline), std::move(tracking_error)));
}

void Motion::setTime(double begin, double end) {
  begin_ = begin;
  end_ = end;
}

double Motion::timeAt(double parameter) const {
  if (parameter >= 1.0) return end_;
  const double time = begin_ + parameter * (end_ - begin_);
  return time > end_ ? end_ : time;  // not std::min, so that NaN gives NaN
}

Positions Motion::Piece::positionsAt(double time) const {
  if (spline) return spline->at(time);
  Positions positions = from;
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += time * (to[i] - from[i]);
  return positions;
}

RobotMotion Motion::Piece::restAt(const Positions& state) const {
  RobotMotion rest;
  robot.after(difference(from, state), Positions(state.size()), rest);
  return rest;
}

Motion::Place Motion::placeOf(double parameter) const {
  const auto is_later = [](double p, const Piece& piece) { return p < piece.begin; };
  const Piece& piece = *std::prev(std::upper_bound(pieces_.begin() + 1, pieces_.end(), parameter, is_later));
  return {piece, (parameter - piece.begin) / (piece.end - piece.begin)};
}

BodyPoses Motion::at(double parameter, const Positions& state) const {
  const auto [piece, time] = placeOf(parameter);
  return piece.spline ? piece.restAt(state.empty() ? piece.positionsAt(time) : state).at(0.0) : piece.robot.at(time);
}

RobotMotion::State Motion::inWorld(double parameter) const {
  const auto [piece, time] = placeOf(parameter);
  return piece.spline ? piece.restAt(piece.positionsAt(time)).inWorld(0.0) : piece.robot.inWorld(time);
}

std::optional<Isometry3d> Motion::worldAt(double parameter, const BodyPoses& bodies) const {
  const auto [piece, time] = placeOf(parameter);
  return piece.robot.worldAt(time, bodies);
}

void Motion::carryObjects(const RobotMotion::ObjectFrames& frames) {
  for (Piece& piece : pieces_) {
    RobotMotion::ObjectFrames part{during(piece.begin, piece.end, frames.world), {}};
    for (const RobotMotion::Segment& frame : frames.moving)
      part.moving.push_back(during(piece.begin, piece.end, frame));
    piece.robot.carryObjects(part);
  }
}

}  // namespace proximity_server::scene
