#pragma once

#include "chance.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/velocity_scale.h"
#include "scene/posed_scene.h"
#include "stress/campaign.h"

#include <memory>
#include <string>
#include <vector>

// The robots of ./dev stress free-motions, stops, people and drives.

namespace proximity_server::scene {

/// The robot of ./dev demo, and one of the package example-robot-data, with their SRDFs, by quickLoading().
std::shared_ptr<const SceneModel> quickDemoModel();
std::shared_ptr<const SceneModel> exampleModel(const MeshResolver& resolve, const std::string& urdf,
                                               const std::string& srdf);

/// A family of cells: a robot with objects.
struct ControlFamily {
  std::string name;
  int rarity;  ///< see stress::Family
  bool has_objects;
  /// The robot of all cells; nullptr: each has one of its own, of small random shapes.
  std::shared_ptr<const SceneModel> robot;
  bool is_coupled = false;  ///< each cell has joint inequalities of its own
};

/// A copy with one to four random inequalities, each of which most random states obey.
std::shared_ptr<const SceneModel> coupled(const SceneModel& model, Chance& chance);

/// A random position of a joint within its limits, or within 3 rad or m.
double randomPosition(const Joint& joint, Chance& chance);

/// Random small robots, the robot of the demo and, where the package example-robot-data is found, Panda, UR5 and PR2
/// with meshes; the first two also with random joint inequalities.
const std::vector<ControlFamily>& controlFamilies();

/// Returns a random source that depends on the part of the run only.
Chance chanceOf(const stress::Part& part);

/// A robot with objects in its state.
class ControlledCell {
 public:
  std::string failure;  ///< says which promise was not kept; empty: none

 protected:
  ControlledCell(const ControlFamily& family, Chance chance);

  void place(const BodyPoses& poses) { objects_ ? scene_.update(poses, frames_) : scene_.update(poses); }
  /// Gives the frames of moving objects random poses.
  void moveFrames();

  Chance chance_;
  const std::shared_ptr<const SceneModel> model_;
  std::shared_ptr<const Objects> objects_;  ///< nullptr: none
  PosedScene scene_;
  FramePoses frames_;
};

/// A stop as a robot makes it.
struct Braked {
  double latency, braking;  ///< [s] with the unscaled velocities

  double duration(double scale) const { return latency + scale * braking; }

  /// Returns the time [s] that the unscaled velocities would need to get as far as the robot got after `time`.
  double wayAfter(double time, double scale) const;
};

/// A robot that moves and brakes.
class StoppingCell : public ControlledCell {
 protected:
  StoppingCell(const ControlFamily& family, Chance chance);

  void choosePositions();
  /// Chooses velocities and brakes, and sets the poses and frames of state_.
  void chooseVelocities();

  /// The positions after the joints moved with their unscaled velocities for a time [s]; at their limits they rest.
  std::vector<double> positionsAfter(double way) const;
  BodyPoses posesAfter(double way) const { return forwardKinematics(model_->robot, positionsAfter(way)); }
  Braked brakes() const;

  MotionSearch moving_;
  std::vector<double> positions_;
  BodyPoses poses_;
  MovingState state_;
  Braking braking_;
};

/// Asks a cell of a family by its observe(), and adds its time and its failure to the tally.
template <class Cell>
void askCell(const ControlFamily& family, const stress::Part& part, stress::Tally& tally) {
  const stress::Stopwatch watch;
  Cell cell(family, chanceOf(part), tally);
  cell.observe();
  tally.add("seconds", watch.seconds());
  if (!cell.failure.empty()) tally.fail({part.number, cell.failure, {}});
}

}  // namespace proximity_server::scene
