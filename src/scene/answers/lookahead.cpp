#include "proximity_server/scene/answers/lookahead.h"

#include "scene/model/numbers.h"
#include "system/durations.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using narrowphase::Status;

bool isDecided(const RobotTimeOfContact& found) {
  return found.status == Status::Converged || found.status == Status::Threshold;
}

}  // namespace

const ContactAhead& Lookahead::find(const Pairs& pairs, const PairDistances& stop, const Stated& stated) {
  follows_.assign(question_.velocities.size(), -1);
  int motions = 0;
  std::string problem;
  if (visitMotions(0, [&] { return ++motions <= kMostMotions; })) {
    asked_.thresholds = &stop;
    asked_.deadline = system::deadlineIn(question_.most_search_time);
    try {
      bool is_first = true;
      visitMotions(0, [&] {
        search(pairs, stated, is_first ? earliest_ : other_);
        if (!is_first) takeEarlier();
        is_first = false;
        return isDecided(earliest_.found);
      });
    } catch (const std::invalid_argument& error) {
      problem = error.what();
    }
  }
  if (motions > kMostMotions || !problem.empty()) earliest_.time_free = kNaN;
  earliest_.motions = motions;
  earliest_.problem = std::move(problem);
  return earliest_;
}

/// Visits the motions in which joints follow splines from `next` on, beside those that `follows_` has, until `visit`
/// returns false. Returns whether it never does.
template <class Visit>
bool Lookahead::visitMotions(std::size_t next, const Visit& visit) {
  if (next == question_.commanded->followed.size()) return visit();
  const FollowedSplines& followed = question_.commanded->followed[next];
  const int index = static_cast<int>(next);
  for (const int joint : followed.joints)
    if (follows_[joint] < 0) follows_[joint] = index;
  const bool is_used = isFollowed(next);
  bool goes_on = !is_used || visitMotions(next + 1, visit);
  std::replace(follows_.begin(), follows_.end(), index, -1);
  if (goes_on && (!is_used || followed.certainty == FollowedSplines::Certainty::PerhapsFollowed))
    goes_on = visitMotions(next + 1, visit);
  return goes_on;
}

bool Lookahead::isFollowed(std::size_t index) const {
  return std::find(follows_.begin(), follows_.end(), static_cast<int>(index)) != follows_.end();
}

/// Searches the motion in which joints follow splines as `follows_` says.
void Lookahead::search(const Pairs& pairs, const Stated& stated, ContactAhead& ahead) {
  const double duration = question_.duration;
  velocities_ = travel_ = question_.velocities;
  for (std::size_t i = 0; i < travel_.size(); ++i) {
    if (follows_[i] >= 0) velocities_[i] = 0.0;
    travel_[i] = velocities_[i] * duration;
    if (!std::isfinite(travel_[i])) throw std::invalid_argument("a velocity times the lookahead is not finite");
  }
  findLimits(question_.search->model().robot, question_.start, travel_, stated, ahead.limits);
  stops_.assign(travel_.size(), duration);
  for (const JointStop& stop : ahead.limits.stops) stops_[stop.joint] = duration * stop.time;

  const SearchTime time = searchTime();
  ahead.question = asked_;
  ahead.motion.setTime(time.begin, time.end);
  ahead.is_along_splines = time.exact >= 0;
  ahead.broken_spline.reset();
  ahead.time_free = ahead.time_to_contact = kNaN;
  searchPieces(pairs, time, ahead);
  if (ahead.found.counts.unknown > 0) {
    ahead.found.contact = false;
    ahead.found.status = Status::Unknown;
    return;
  }
  const auto within = [&](double seconds) { return std::clamp(seconds, 0.0, duration); };
  ahead.time_free = within(ahead.motion.timeAt(ahead.found.t_free) - time.ahead);
  if (ahead.found.contact)
    ahead.time_to_contact = within(ahead.motion.timeAt(ahead.found.t_contact));
  else if (isDecided(ahead.found))
    ahead.time_free = duration;
}

/// The times of splines whose delay is known worst are exact, so that the way in this time is not added to their error.
Lookahead::SearchTime Lookahead::searchTime() const {
  SearchTime time{0.0, question_.duration};
  const std::vector<FollowedSplines>& followed = question_.commanded->followed;
  for (std::size_t i = 0; i < followed.size(); ++i) {
    const double behind = followed[i].behind, later = followed[i].ahead;
    if (isFollowed(i) && (time.exact < 0 || behind + later > time.behind + time.ahead))
      time = {-behind, question_.duration + later, behind, later, static_cast<int>(i)};
  }
  return time;
}

/// Makes and searches one piece after another, until a contact is found, or until one along splines is not decided.
void Lookahead::searchPieces(const Pairs& pairs, const SearchTime& time, ContactAhead& ahead) {
  const RobotModel& model = question_.search->model().robot;
  RobotTimeOfContact& found = ahead.found;
  Motion::Piece& piece = ahead.motion.onlyPiece();
  piece.end = 0.0;
  bool goes_on = true;
  while (goes_on && piece.end < 1.0) {
    piece.begin = piece.end;
    piece.end = ahead.is_along_splines ? pieceEnd(piece.begin, time) : nextStop(ahead.limits.stops, piece.begin);
    ahead.is_along_splines ? makeSpline(time, piece) : makeStraight(ahead.limits.stops, piece);
    const RobotTimeOfContact next = question_.search->timeOfContact(pairs, ahead.motion, ahead.question);
    found = piece.begin > 0.0 ? followedBy(found, next) : next;
    goes_on = !found.contact && found.counts.unknown == 0 && !(ahead.is_along_splines && !isDecided(found));
    if (!ahead.is_along_splines || ahead.broken_spline || (piece.begin > 0.0 && found.t_contact <= piece.begin))
      continue;
    const std::vector<SplineSegment::Break> broken = piece.spline->brokenInequalities(model);
    if (broken.empty()) continue;
    ahead.broken_spline = broken.front();
    ahead.broken_spline->time = std::max(0.0, piece.spline->timeAt(broken.front().time));
  }
}

/// The parameter at which a piece along splines ends: no spline begins or ends in it, and no joint stops.
double Lookahead::pieceEnd(double begin, const SearchTime& time) const {
  double end = 1.0;
  const auto parameterOf = [&](double seconds) { return (seconds - time.begin) / (time.end - time.begin); };
  const auto consider = [&](double seconds) {
    if (parameterOf(seconds) > begin) end = std::min(end, parameterOf(seconds));
  };
  consider(0.0);
  consider(question_.duration);
  for (const double stop : stops_) consider(stop);
  for (std::size_t i = 0; i < question_.commanded->followed.size(); ++i) {
    if (!isFollowed(i)) continue;
    const FollowedSplines& followed = question_.commanded->followed[i];
    const std::vector<SplineSegment>& segments = followed.splines->segments;
    const auto next = std::partition_point(segments.begin(), segments.end(), [&](const SplineSegment& segment) {
      return !(parameterOf(segment.end() - followed.time) > begin);
    });
    if (next == segments.end()) continue;
    consider(next->begin() - followed.time);
    consider(next->end() - followed.time);
  }
  return end;
}

void Lookahead::makeStraight(const std::vector<JointStop>& stops, Motion::Piece& piece) {
  if (piece.begin == 0.0)
    poses_ = question_.start;
  else
    piece.robot.at(1.0, poses_);
  during_ = travel_;
  restrictTravel(piece.begin, piece.end, stops, during_);
  piece.robot.setTravel(question_.search->model().robot, poses_, during_);
  piece.robot.carryObjects(question_.frames);
  piece.spline.reset();
  piece.from.clear();
  piece.tracking_error.clear();
}

void Lookahead::makeSpline(const SearchTime& time, Motion::Piece& piece) {
  const CommandedMotion& commanded = *question_.commanded;
  const double from = time.at(piece.begin), to = time.at(piece.end);
  if (piece.begin == 0.0) {
    during_.assign(travel_.size(), 0.0);
    piece.robot.setTravel(question_.search->model().robot, question_.start, during_);
    piece.robot.carryObjects(question_.frames);
    piece.from = commanded.positions;
    if (!piece.spline) piece.spline.emplace();
  }
  piece.spline->rest(from, to, commanded.positions);
  piece.tracking_error.assign(follows_.size(), 0.0);
  for (std::size_t i = 0; i < follows_.size(); ++i) {
    const int joint = static_cast<int>(i);
    double& error = piece.tracking_error[i];
    if (follows_[i] < 0) {
      const auto positionAt = [&](double seconds) {
        return commanded.positions[i] + velocities_[i] * std::clamp(seconds, 0.0, stops_[i]);
      };
      piece.spline->goStraight(joint, positionAt(from), positionAt(to));
      error = std::abs(velocities_[i]) * std::max(time.behind, time.ahead);
      continue;
    }
    const FollowedSplines& followed = commanded.followed[follows_[i]];
    const JointSplines& splines = *followed.splines;
    const double begin = followed.time + from, end = followed.time + to;
    splines.copyTo(*piece.spline, joint, begin, end);
    const double shift =
        follows_[i] == time.exact ? 0.0 : std::max(time.behind + followed.ahead, time.ahead + followed.behind);
    error = commanded.tracking_error[i] + splines.inexactAt(joint, begin - shift) +
            shift * splines.largestSpeed(joint, begin - shift, end + shift);
  }
}

/// Joins two answers of which either may be true: the earlier contact counts, and there is none only if both say so.
void Lookahead::takeEarlier() {
  const auto isKnown = [](const ContactAhead& ahead) { return ahead.found.contact || isDecided(ahead.found); };
  const auto isFree = [](const ContactAhead& ahead) { return !ahead.found.contact && isDecided(ahead.found); };
  ContactAhead &a = earliest_, &b = other_;
  if (std::isnan(b.time_free) || (b.found.contact && !(a.time_to_contact <= b.time_to_contact)) ||
      (!isKnown(b) && isFree(a)))
    std::swap(a, b);
  if (!(b.time_free < a.time_free)) return;
  a.time_free = b.time_free;
  if (!isKnown(b) && a.found.contact) a.found.status = b.found.status;
}

}  // namespace proximity_server::scene
