#pragma once

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"
#include "proximity_server/scene/state/state.h"
#include "python/joint_positions.h"
#include "python/loading.h"
#include "python/pair_numbers.h"

#include <pybind11/pybind11.h>
#include <Eigen/Core>

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::python {

class Scratch;

/// The data that robots share which differ in their objects only: the model, and the scenes that are copied for
/// questions.
struct LoadedRobot;

/// A robot with its objects and candidate pairs: the class `Robot` of the module, which questions.h asks. Only its
/// number of threads can be changed: a change of the objects makes another robot, which shares all unchanged data.
class Robot {
 public:
  /// Loads a robot without objects.
  /// Failure: throws as load() and thresholdsOf() do, and as setThreads() does.
  Robot(RobotText text, LoadOptions options, int threads, const std::atomic<bool>* stop);
  ~Robot();

  const std::shared_ptr<const scene::SceneModel>& model() const;
  const RobotText& text() const;
  const LoadOptions& options() const;
  const scene::LevelThresholds* thresholds() const;  ///< nullptr: there are no levels
  const scene::Candidates& candidates() const;       ///< the checked pairs of links
  const PairNumbers& pairs() const;

  /// The link or object of a name. Throws std::invalid_argument with the nearest name if there is none.
  scene::ShapeRef shapeNamed(const std::string& name) const;

  /// The largest number of threads of a question, from 1 to 1024.
  int threads() const { return threads_; }
  /// Throws std::invalid_argument for another number.
  void setThreads(int threads);

  // --- objects, see object_file.h. Errors are an std::invalid_argument that names the object.

  const std::shared_ptr<const scene::Objects>& objects() const { return objects_; }
  const std::vector<scene::WrittenRule>& rules() const { return rules_; }

  /// Returns the robot with these objects and rules. An object with the name of a present one replaces it, and the
  /// rules are added behind the present ones. Warnings about the objects are added to `warnings`.
  std::unique_ptr<Robot> with(std::vector<scene::ObjectEdit> objects, const std::vector<scene::WrittenRule>& rules,
                              const std::atomic<bool>* stop, std::vector<std::string>& warnings) const;

  /// Returns the robot after an operation on one object. If q is not None, the object stays where it is in the state q.
  std::unique_ptr<Robot> edited(scene::ObjectEdit edit, const pybind11::object& q) const;

  /// Returns the robot with a rule that allows a pair to touch.
  std::unique_ptr<Robot> allowing(const std::string& a, const std::string& b) const;

  // --- for questions

  // With the objects, for one thread.
  scene::SceneBatch newBatch() const;
  scene::State newState() const;

  /// Lends a scratch until the pointer is destroyed; the robot must outlive it. Thread-safe.
  std::shared_ptr<Scratch> borrow();

 private:
  Robot(std::shared_ptr<const LoadedRobot> loaded, scene::Objects objects, std::vector<scene::WrittenRule> rules,
        int threads);
  std::unique_ptr<Robot> changed(const scene::ObjectEditor& editor, const std::vector<scene::WrittenRule>& rules) const;

  std::shared_ptr<const LoadedRobot> loaded_;
  std::shared_ptr<const scene::Objects> objects_;
  std::vector<scene::WrittenRule> rules_;
  int threads_;
  mutable std::once_flag pairs_made_, batch_made_;
  mutable std::optional<PairNumbers> pairs_;
  mutable std::optional<scene::SceneBatch> batch_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> free_scratches_;  ///< those that are not borrowed
  std::size_t scratch_count_ = 0;                         ///< number of all scratches
};

/// The answerers of one thread, with their memory, for a robot with its objects. A question makes those that it needs and
/// that are not there yet. The robot must outlive it.
class Scratch {
 public:
  explicit Scratch(const Robot& robot) : robot_(robot) {}

  scene::SceneBatch& batch() { return batch_ ? *batch_ : batch_.emplace(robot_.newBatch()); }
  scene::State& state() { return state_ ? *state_ : state_.emplace(robot_.newState()); }
  scene::FreeMotion& freeMotion() { return free_motion_ ? *free_motion_ : free_motion_.emplace(robot_.model()); }
  scene::PointSearch& points() { return points_ ? *points_ : points_.emplace(robot_.model()); }
  scene::RaySearch& rays() { return rays_ ? *rays_ : rays_.emplace(robot_.model()); }
  scene::GuaranteedDistances& guaranteed() { return guaranteed_ ? *guaranteed_ : guaranteed_.emplace(robot_.model()); }

  /// Takes the poses of a state of the block.
  const scene::State& place(const JointPositions::Block& block, Eigen::Index index) {
    positionsOf(block, index, positions);
    setPositions(state(), positions);
    return state();
  }

  std::vector<double> positions;  ///< of one state
  Eigen::VectorXd by_degrees;     ///< a gradient or a motion with respect to the degrees of freedom

 private:
  const Robot& robot_;
  std::optional<scene::SceneBatch> batch_;
  std::optional<scene::State> state_;
  std::optional<scene::FreeMotion> free_motion_;
  std::optional<scene::PointSearch> points_;
  std::optional<scene::RaySearch> rays_;
  std::optional<scene::GuaranteedDistances> guaranteed_;
};

}  // namespace proximity_server::python
