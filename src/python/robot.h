#pragma once

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "python/driven_edges.h"
#include "python/joint_positions.h"
#include "python/loading.h"
#include "python/pair_numbers.h"
#include "python/rows.h"

#include <pybind11/numpy.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::python {

/// The scenes and the memory that one thread needs for its questions.
struct Scratch;

/// The data that robots share which differ in their objects only: the model, and the scenes that are copied for
/// questions.
struct LoadedRobot;

/// An array of rows about pairs.
class RowTable;

/// Ends a long question.
class SignalWatch;

/// The dtype of LevelRow. It has the fields of PairRow, and the level.
pybind11::dtype leveledPairType();

/// The dtype of MinimumRow. It has the fields of PairRow, and the time.
pybind11::dtype minimumType();

/// A robot with its objects and candidate pairs: the class `Robot` of the module. Only its number of threads can be
/// changed: a change of the objects makes another robot, which shares all unchanged data.
///
/// Many Python threads may ask questions at once. A question releases the GIL while it computes, and each of its
/// threads borrows a scratch. Ctrl-C ends a question, and so does the end of its time budget: what is not answered by
/// then is unknown.
class Robot {
 public:
  /// Loads a robot without objects.
  /// Failure: throws as load() and thresholdsOf() do, and as setThreads() does.
  Robot(RobotText text, LoadOptions options, int threads, const std::atomic<bool>* stop);
  ~Robot();

  const scene::SceneModel& model() const;
  const RobotText& text() const;
  const LoadOptions& options() const;
  const PairNumbers& pairs() const;

  /// The largest number of threads of a question, from 1 to 1024.
  int threads() const { return threads_; }
  /// Throws std::invalid_argument for another number.
  void setThreads(int threads);

  // --- objects, see object_file.h. Errors are an std::invalid_argument that names the object.

  const scene::Objects& objects() const { return *objects_; }
  const std::vector<scene::WrittenRule>& rules() const { return rules_; }

  /// Returns the robot with these objects and rules. An object with the name of a present one replaces it, and the
  /// rules are added behind the present ones. Warnings about the objects are added to `warnings`.
  std::unique_ptr<Robot> with(std::vector<scene::ObjectEdit> objects, const std::vector<scene::WrittenRule>& rules,
                              const std::atomic<bool>* stop, std::vector<std::string>& warnings) const;

  /// Returns the robot after an operation on one object. If q is not None, the object stays where it is in the state q.
  std::unique_ptr<Robot> edited(scene::ObjectEdit edit, const pybind11::object& q) const;

  /// Returns the robot with a rule that allows a pair to touch.
  std::unique_ptr<Robot> allowing(const std::string& a, const std::string& b) const;

  using TimeBudget = std::optional<double>;  ///< [s]; nullopt: none

  // --- The questions. The docstrings in module.cpp document their results and errors.

  pybind11::object minimum(const pybind11::object& q, std::optional<double> accuracy, TimeBudget time_budget);
  pybind11::object level(const pybind11::object& q, TimeBudget time_budget);
  pybind11::object closest(const pybind11::object& q, long k, TimeBudget time_budget);
  /// Returns the rows and gradients of minimum(), or of closest() if k has a value.
  pybind11::tuple gradient(const pybind11::object& q, std::optional<long> k, TimeBudget time_budget);
  /// Returns the pair of each state with the smallest guaranteed distance, and this distance.
  pybind11::tuple guaranteed(const pybind11::object& q, const std::string& uncertainty, TimeBudget time_budget);
  pybind11::object below(const pybind11::object& q, double distance, TimeBudget time_budget);
  pybind11::object pairsBelow(const pybind11::object& q, double distance, TimeBudget time_budget);
  pybind11::object freeMotion(const pybind11::object& q, double distance, double influence_distance,
                              TimeBudget time_budget);
  pybind11::object freeScale(const pybind11::object& q, const pybind11::object& motion, double distance,
                             double influence_distance, TimeBudget time_budget);
  /// Returns a row for each pair, and the closest states that were found.
  pybind11::tuple prove(const pybind11::object& lower, const pybind11::object& upper, double distance, long boxes,
                        TimeBudget time_budget);
  pybind11::object linkPoses(const pybind11::object& q);
  pybind11::object firstContact(const pybind11::object& start, const pybind11::object& goal, double distance,
                                double tolerance, const EdgeMotion& motion, TimeBudget time_budget);
  pybind11::object minimumBetween(const pybind11::object& start, const pybind11::object& goal, double tolerance,
                                  const EdgeMotion& motion, TimeBudget time_budget);

 private:
  Robot(std::shared_ptr<const LoadedRobot> loaded, std::shared_ptr<const scene::Objects> objects,
        std::vector<scene::WrittenRule> rules, int threads);
  std::unique_ptr<Robot> withEdits(const scene::ObjectEditor& editor) const;

  /// Questions are asked of copies made by forAnotherThread().
  const scene::SceneBatch& freshBatch() const;

  std::shared_ptr<Scratch> borrow();
  scene::SceneBatch& batchOf(Scratch& scratch) const;

  /// Calls `answer(scratch, first, count)` for all blocks of `block` items, without the GIL. There are `count` items.
  template <typename Answer>
  void answerBlocks(Eigen::Index count, Eigen::Index block, SignalWatch& watch, const Answer& answer);

  /// Calls `answer(batch, scratch, block, first)` for all blocks of states; `batch` is a SceneBatch.
  template <typename Answer>
  void answerStates(const JointPositions& positions, SignalWatch& watch, const Answer& answer);

  /// Writes k rows for each state about the pairs that `ask(batch, block, deadline)` returns, and k gradients unless
  /// `gradients` is nullptr.
  template <typename Ask>
  void answerRows(const JointPositions& positions, Eigen::Index k, const Ask& ask, TimeBudget time_budget,
                  RowTable& rows, double* gradients);

  /// Calls `write(state, free, scratch)` for the free motion from each state. `free` is a FreeMotion; nullptr for a
  /// state without an answer.
  template <typename Write>
  void answerFreeMotions(const JointPositions& positions, double distance, double influence_distance,
                         TimeBudget time_budget, const Write& write);

  /// Returns the row of each edge about the result of `ask(scene, motion, question)`: a MovingScene with a RobotMotion
  /// and a MotionQuestion, or a SplineScene with a SplineSegment and a SplineQuestion.
  template <typename Ask>
  pybind11::object answerEdges(const DrivenEdges& edges, scene::MotionQuestion question, TimeBudget time_budget,
                               const pybind11::dtype& type, const Ask& ask);

  const scene::LevelThresholds* thresholds() const;

  std::shared_ptr<const LoadedRobot> loaded_;
  std::shared_ptr<const scene::Objects> objects_;
  std::vector<scene::WrittenRule> rules_;
  int threads_;
  mutable std::once_flag pairs_made_, batch_made_;
  mutable std::unique_ptr<PairNumbers> pairs_;
  mutable std::optional<scene::SceneBatch> batch_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> free_scratches_;  ///< those that are not borrowed
  std::size_t scratch_count_ = 0;                         ///< number of all scratches
};

}  // namespace proximity_server::python
