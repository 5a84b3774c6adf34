#pragma once

#include "proximity_server/scene/answers/pair_selection.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/motion/joint_spline.h"
#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"
#include "tools/program/time_budget.h"
#include "tools/robot/object_schedule.h"

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The pairs of a state that are written.
struct PairSelection : scene::PairSelection {
  double threshold = std::numeric_limits<double>::infinity();  ///< [m] for Below and Any
  double accuracy = 0.0;  ///< [m] for Minimum: how far its bounds may be apart; 0: the distance, as exact as it can be
};

/// Reads "all", "minimum", "minimum:1e-4" (the accuracy), "below:0.05", "any:0.05" or "k:5". Throws std::invalid_argument naming the text.
PairSelection readPairSelection(const std::string& text);

/// The text that is read as the selection, one for each.
std::string textOf(const PairSelection& selection);

/// A row describes one pair in a state, or one segment of a trajectory.
enum class RowKind : unsigned char { State, Segment };

/// Whether neighbours and disabled pairs are left out.
enum class PairFilter : unsigned char { On, Off };

/// The pairs of links that the filter leaves, of those that have geometry and do not belong to one body.
std::vector<scene::ShapeRefPair> checkedPairs(const scene::SceneModel& model, PairFilter filter);

/// How joint_trajectory_controller moves the joints from one way point to the next: with the positions of the way points
/// alone, with their velocities, or also with their accelerations.
enum class Interpolation : unsigned char { Linear, Cubic, Quintic };

/// The question about each state or segment.
struct ClearanceQuestion {
  std::shared_ptr<const scene::SceneModel> model;
  PairFilter filter = PairFilter::On;
  std::vector<scene::ShapeRefPair> pairs;   ///< pairs of links, as the filter says
  std::shared_ptr<ObjectSchedule> objects;  ///< nullptr: there are none
  /// Those of the filter, if there are objects; nullopt: all pairs that have geometry.
  std::optional<scene::Candidates> candidates;
  std::optional<scene::LevelThresholds> thresholds;  ///< nullopt: there are no levels
  /// nullopt: the states are exact. For states and the filter's pairs; not with accuracy and Kind::Any.
  std::optional<scene::Uncertainty> uncertainty;
  std::optional<scene::Points> points;  ///< for states: the rows are about them, and not about pairs
  /// "": none
  std::string points_file, objects_file, thresholds_file, uncertainty_text, tracking_error_text, start_text;
  PairSelection selection;                              ///< for states
  scene::Skipping skipping = scene::Skipping::On;       ///< for states
  scene::MotionQuestion motion;                         ///< for segments
  Interpolation interpolation = Interpolation::Linear;  ///< for segments
  std::vector<double> tracking_error;                   ///< [rad] or [m] of each joint, for segments; empty: none
  std::optional<scene::TrajectoryPoint> start;  ///< of the controller, for segments; nullopt: the first way point
  /// The rows are the same as without it. Then the run ends with an error.
  TimeBudget budget;
  int threads = 1;
};

/// The pairs of a question, those with objects too.
class QuestionPairs {
 public:
  /// The question must outlive this.
  explicit QuestionPairs(const ClearanceQuestion& question) : question_(question) {}

  /// Takes the pairs of the objects, if they are others than before. Returns whether they are.
  bool use(const std::shared_ptr<const scene::Objects>& objects) {
    if (!objects || objects == objects_) return false;
    objects_ = objects;
    take(*objects);
    return true;
  }

  scene::Pairs get() const {
    if (question_.candidates) return *question_.candidates;
    return question_.objects ? with_objects_ : question_.pairs;
  }

  /// The pairs of get() one by one; `objects` are from the last use(), nullptr if there are none.
  std::vector<scene::ShapeRefPair> list(const scene::Objects* objects) const;

 private:
  void take(const scene::Objects& objects);

  const ClearanceQuestion& question_;
  std::shared_ptr<const scene::Objects> objects_;  ///< of the last use()
  std::vector<scene::ShapeRefPair> with_objects_;  ///< without filter
};

/// Whether a list has a pair there: the answer about a state without one names none.
inline bool isNamed(const scene::ShapeRefPair& pair) { return pair.a != scene::ShapeRef(); }

/// The worst level of a segment by the thresholds of each pair.
struct SegmentLevel {
  scene::ClearanceLevel level = scene::ClearanceLevel::Clear;
  double time = std::numeric_limits<double>::quiet_NaN();  ///< [s] proven not to be reached before; NaN for Clear
  scene::ShapeRefPair pair{};                              ///< that reaches it first; without links for Clear
};

/// The answer about one state, or about one segment of a trajectory, for those who read more than its row.
struct ClearanceAnswer {
  /// The answer about a pair. Its bounds are about the whole segment. With an uncertainty the lower one is guaranteed.
  struct OfPair {
    scene::PairProximity pair;
    narrowphase::Status status = narrowphase::Status::Unknown;  ///< of the search for it in the whole segment
    double time = std::numeric_limits<double>::quiet_NaN();     ///< [s] when it is closest; NaN: the state has no time
    scene::Positions positions{};                               ///< then
  };

  /// A part of a segment.
  struct Part {
    double begin, end;                  ///< [s]
    double lower_bound;                 ///< [m] of all pairs; NaN: there is no answer
    std::optional<SegmentLevel> level;  ///< as `level`
  };

  long number = 0;                                  ///< counted from 0
  double begin = 0.0, end = 0.0;                    ///< [s] of a segment
  std::shared_ptr<const scene::Objects> objects{};  ///< nullptr: there are none
  /// The closest pair, with the bounds of all; without links if no pair has an answer. From a state only its time and
  /// positions if the assertion is not asked for.
  OfPair closest{};
  int unknown_pairs = 0;                       ///< pairs without an answer
  scene::RobotTimeOfContact contact{};         ///< of a segment; its times in seconds
  std::optional<SegmentLevel> level{};         ///< nullopt: a pair has no answer, or there are no thresholds
  std::vector<scene::PairProximity> listed{};  ///< for the second opinion
  std::vector<OfPair> of_pairs{};              ///< of each pair by itself; for the report
  std::vector<Part> parts{};                   ///< of a segment, in their order; for the report
};

}  // namespace proximity_server::tools
