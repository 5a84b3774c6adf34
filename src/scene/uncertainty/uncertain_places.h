#pragma once

#include "proximity_server/scene/state/state.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"
#include "scene/state/part.h"
#include "scene/uncertainty/displacements.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace proximity_server::scene {

/// A shape in a state, and what displaces it.
struct DisplacedShape {
  Part part;
  Eigen::Isometry3d pose;           ///< of the frame of the part
  std::vector<Displacement> chain;  ///< from the shape to a body
};

/// Lists the displacements by which the shapes of a state can be off relative to each other, under an uncertainty.
class UncertainPlaces {
 public:
  explicit UncertainPlaces(const std::shared_ptr<const SceneModel>& model);

  void assume(const Uncertainty& uncertainty);
  const Uncertainty& uncertainty() const { return uncertainty_; }

  /// The changes since the last call of see(). Another uncertainty counts as other poses.
  enum class News : unsigned char { None, Poses, Objects };
  /// Takes a state, which must stay as it is until the next call. Throws std::invalid_argument for one of another robot.
  News see(const State& state);

  const State& state() const { return *state_; }
  const RobotModel& robot() const { return model_->robot; }

  /// The leader of each joint.
  const std::vector<Joint::Mimic>& leaders() const { return leaders_; }
  /// The leader of the joint which makes a displacement; nullptr if a frame, a base or an object makes it.
  const Joint::Mimic* leaderOf(const Displacement& own) const;

  /// The displacements of a body relative to its parent.
  struct Place {
    bool is_found = false;  ///< for the present poses and uncertainty
    bool is_known = false;  ///< false if a pose is missing that is needed
    std::vector<Displacement> displacements;
  };
  const Place& placeOf(int body);

  /// Takes a shape, and begins its chain with what it is itself, as the displacement of this place. Returns false if its
  /// pose is missing.
  bool place(const ShapeRef& ref, int place, DisplacedShape& shape) const;

  /// The uncertainty of an object, by its number.
  const PoseUncertainty& ofObject(int number) const { return object_frames_[number].uncertainty; }
  /// Its origin, about which it is turned: in the frame of what carries it, and in the frame of the poses.
  const Eigen::Vector3d& originOf(int number) const { return object_frames_[number].origin; }
  Eigen::Vector3d originAt(int number, const Eigen::Isometry3d& pose) const;

  /// The point about which the frame of the joint of a body is turned, in the frame of the poses.
  Eigen::Vector3d jointOrigin(int body) const;

  double swellingOf(const ShapeRef& ref) const { return ref.isLink() ? uncertainty_.swellings[ref.link()] : 0.0; }

 private:
  void placeObjects();
  bool addPlace(int body, std::vector<Displacement>& chain) const;

  struct ObjectFrame {
    PoseUncertainty uncertainty;
    Eigen::Vector3d origin;  ///< in the frame of what carries the object
  };

  const std::shared_ptr<const SceneModel> model_;
  const State* state_ = nullptr;
  std::uint64_t revision_ = 0;              ///< of the state; 0: the uncertainty is new
  std::shared_ptr<const Objects> objects_;  ///< of the state
  Uncertainty uncertainty_;
  std::vector<Joint::Mimic> leaders_;
  std::vector<ObjectFrame> object_frames_;  ///< by the numbers of the objects
  std::vector<Place> places_;               ///< by body
};

}  // namespace proximity_server::scene
