#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "tools/robot/robot_files.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The objects of a file on the way through states: those that are there from the start, then those after each change.
///
/// Frames are links, whose poses follow from the state; the root link is the frame in which things stand still.
class ObjectSchedule {
 public:
  /// Makes the geometry of all objects, and tries all changes once with all joints at 0, so that what is wrong is known
  /// before the first state.
  /// Failure: throws std::invalid_argument naming the place in the file, the object and the reason.
  ObjectSchedule(const std::shared_ptr<const scene::SceneModel>& model, const scene::ObjectFile& file,
                 const scene::ObjectOptions& options,
                 scene::ObjectRules::FreeObjects free_objects = scene::ObjectRules::FreeObjects::NotChecked);

  /// Makes the changes that are due before the state of this row and time [s], in their order. NaN: it has no time.
  void advance(long row, double time, const scene::Positions& positions);

  /// The objects after the last advance().
  const std::shared_ptr<const scene::Objects>& now() const { return now_; }

  /// The time [s] of the next change, if it has one.
  std::optional<double> nextTime() const;

  bool hasTimes() const;

  /// A warning about changes that are not made yet; "" if there are none.
  std::string leftOver() const;

  /// All objects that the file makes, without a place: the objects from the start, then the objects of its changes.
  const std::vector<scene::Object>& all() const { return all_; }

  /// One sentence about each oddity of a mesh.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void apply(const std::vector<scene::ObjectEdit>& edits, const scene::BodyPoses& poses);
  void makeGeometry(scene::ObjectEdit& edit);

  std::shared_ptr<const scene::SceneModel> model_;
  const scene::ObjectOptions options_;
  std::shared_ptr<const scene::Objects> now_;
  std::vector<scene::WrittenChange> steps_;
  std::size_t next_ = 0;
  std::vector<scene::Object> all_;
  std::vector<std::string> warnings_;
};

/// Reads the objects of a file, or else of --config, with the meshes as of the robot, and prints their warnings.
/// nullptr if there are none.
/// Failure: throws std::invalid_argument as readObjectFile() and ObjectSchedule do.
std::shared_ptr<ObjectSchedule> loadObjects(const std::string& path, const RobotFiles& robot,
                                            const std::shared_ptr<const scene::SceneModel>& model);

}  // namespace proximity_server::tools
