#pragma once

#include "proximity_server/scene/answers/commanded_motion.h"
#include "proximity_server/scene/motion/limited_motion.h"
#include "proximity_server/scene/motion/motion_search.h"

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// A state of a robot, and what moves it from then on. All poses that are needed are known.
struct LookaheadQuestion {
  MotionSearch* search = nullptr;  ///< never nullptr; with the objects of the state
  double duration = 0.0;           ///< [s] so far ahead
  double most_search_time = 0.0;   ///< [s]
  /// The poses at the start, in a frame in which the roots rest, and where the objects are in it; each frame of objects
  /// rests in its parent.
  BodyPoses start;
  RobotMotion::ObjectFrames frames;
  std::vector<double> velocities;              ///< [rad/s] or [m/s] of RobotModel::joints
  const CommandedMotion* commanded = nullptr;  ///< never nullptr
};

/// The first contact in the time of a lookahead. Times [s] count from the start.
struct ContactAhead {
  /// Whether there is a contact, or why it is not decided; `t_free` and `t_contact` are parameters of `motion`.
  RobotTimeOfContact found;
  Motion motion{RobotMotion()};                                 ///< its last piece that was searched
  MotionQuestion question;                                      ///< that was asked
  double time_free = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not known
  double time_to_contact = std::numeric_limits<double>::quiet_NaN();
  MotionLimits limits;            ///< of the joints that follow no splines
  bool is_along_splines = false;  ///< an inequality that is broken is in `broken_spline`, and not in `limits`
  std::optional<SplineSegment::Break> broken_spline;  ///< the first one that is broken along them; time [s]
  int motions = 0;                                    ///< that were to be searched, see Lookahead::kMostMotions
  std::string problem;  ///< why nothing is known, with the name of the joint; "" if something is
};

/// Searches for the first contact, if joints follow the splines of commands, and all others keep their velocities until
/// a limit. A contact of a pair is at its stop distance.
///
/// 1. Splines that are only perhaps followed may be left out, together with others or alone: the earliest contact of
///    all these motions counts, and none only if no motion has one.
/// 2. Each begin and end of a spline, and each stop at a limit, ends a piece of the motion. Pieces are made and searched
///    one by one.
/// 3. A delay that is not known exactly shifts splines in time. Those whose delay is known worst are searched in the
///    time of the poses, widened by the delay; of all others the way in that time is added to their tracking error.
///
/// The answer is proven for all motions within the tracking errors of the followers. After the first few questions
/// nothing is allocated while there is no contact, no stop and the same joints follow splines.
class Lookahead {
 public:
  /// So many motions are searched within the time of one: the motions of five controllers that may follow their
  /// trajectories or not. If there are more, none is searched.
  static constexpr int kMostMotions = 32;

  LookaheadQuestion& question() { return question_; }

  using Stated = std::vector<std::optional<double>>;  ///< positions, see motionWithinLimits()

  /// The answer is valid until the next question.
  const ContactAhead& find(const Pairs& pairs, const PairDistances& stop, const Stated& stated);

 private:
  /// The time of a search, from `begin` to `end` after the stamp of the poses [s]; true times differ from the time of
  /// `exact` by at most `behind` or `ahead`.
  struct SearchTime {
    double begin, end, behind = 0.0, ahead = 0.0;
    int exact = -1;  ///< index into CommandedMotion::followed; -1: no joint follows splines
    double at(double parameter) const { return begin + parameter * (end - begin); }
  };

  template <class Visit>
  bool visitMotions(std::size_t next, const Visit& visit);
  void search(const Pairs& pairs, const Stated& stated, ContactAhead& ahead);
  void searchPieces(const Pairs& pairs, const SearchTime& time, ContactAhead& ahead);
  bool isFollowed(std::size_t index) const;
  SearchTime searchTime() const;
  double pieceEnd(double begin, const SearchTime& time) const;
  void makeStraight(const std::vector<JointStop>& stops, Motion::Piece& piece);
  void makeSpline(const SearchTime& time, Motion::Piece& piece);
  void takeEarlier();

  LookaheadQuestion question_;
  MotionQuestion asked_;
  ContactAhead earliest_, other_;
  // Working memory of one motion.
  std::vector<int> follows_;                 ///< by joint: index into CommandedMotion::followed; -1: none
  std::vector<double> velocities_, travel_;  ///< 0 for the joints that follow splines
  std::vector<double> during_, stops_;       ///< the travel in a piece; [s] when joints stop
  BodyPoses poses_;
};

}  // namespace proximity_server::scene
