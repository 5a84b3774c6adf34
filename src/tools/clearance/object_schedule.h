#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/objects.h"

namespace proximity_server::tools {

/// The objects of a file on the way through states: those that are there from the start, then those after each change.
///
/// Frames are links, whose poses follow from the state; the root link is the frame in which things stand still.
class ObjectSchedule {
 public:
  /// Makes the geometry of all objects, and tries all changes once with all joints at 0, so that what is wrong is known before the first state.
  /// Failure: throws std::invalid_argument naming the place in the file, the object and the reason.
  ObjectSchedule(const std::shared_ptr<const scene::SceneModel>& model, const scene::ObjectFile& file,
                 const scene::ObjectOptions& options);

  /// Makes the changes that are due before the state of this row and time [s], in their order.
  void advance(long row, std::optional<double> time, const scene::Positions& positions);

  /// The objects after the last advance().
  const std::shared_ptr<const scene::Objects>& now() const { return now_; }

  /// The time [s] of the next change, if it has one.
  std::optional<double> nextTime() const;

  bool hasTimes() const;

  /// A warning about changes that are not made yet; "" if there are none.
  std::string leftOver() const;

  /// All objects that the file makes: those from the start, then those of its changes, as they are first placed.
  const std::vector<scene::Object>& all() const { return all_; }

  /// One sentence about each oddity of a mesh.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  struct Step {
    scene::WrittenChange change;
    scene::Object object;  ///< of Add and Replace
  };
  void addOneByOne(const std::vector<scene::WrittenObject>& objects, const std::vector<scene::ObjectChange>& additions);
  void make(const Step& step, const scene::BodyPoses& poses);
  scene::ObjectChange changeFor(const Step& step, const scene::BodyPoses& poses) const;
  scene::Object made(const scene::WrittenObject& object, const scene::ObjectOptions& options);

  std::shared_ptr<const scene::SceneModel> model_;
  std::shared_ptr<const scene::Objects> now_;
  std::vector<Step> steps_;
  std::size_t next_ = 0;
  std::vector<scene::Object> all_;
  std::vector<std::string> warnings_;
};

}  // namespace proximity_server::tools
