#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "moving_bodies.h"
#include "proximity_server/scene/moving_scene.h"
#include "volumes.h"

namespace proximity_server {

/// Answers questions about pairs of subjects in motion: walks through volumes and time at once, and gives only the
/// pieces and intervals to the narrowphase that neither spheres nor boxes settle.
class MotionSearch {
 public:
  explicit MotionSearch(std::shared_ptr<const SceneModel> model);

  const SceneModel& model() const { return *model_; }

  RobotContact firstContact(const std::vector<SubjectPair>& pairs, const RobotMotion& motion,
                            const MotionQuestion& question);
  RobotMinimum minimum(const std::vector<SubjectPair>& pairs, const RobotMotion& motion,
                       const MotionQuestion& question);

 private:
  struct MovingSubjects {
    SubjectPair asked;
    double padding;  ///< [m]
    int a, b;        ///< volumes
    MovingBodies bodies;
  };

  /// Two volumes during an interval of time, see MovingBodies::Interval.
  struct Visit {
    double lower_bound;  ///< [m] of their signed distance less the padding
    int subjects;        ///< index into subjects_
    int a, b, interval;
    double travel;  ///< [m] of b as seen from a
  };
  enum class Order : unsigned char { Nearest, Earliest };

  void begin(const std::vector<SubjectPair>& pairs, const RobotMotion& motion, Order order, MotionCounts& counts);
  int enterAll(double limit);
  double paddingOf(const SubjectPair& pair) const;
  MovingSubjects& subjectsOf(const Visit& visit) { return subjects_[static_cast<std::size_t>(visit.subjects)]; }
  const Piece& pieceOf(int leaf) const;

  bool goesLater(const Visit& p, const Visit& q) const;
  void push(const Visit& visit);
  Visit pop();

  Visit withSpheres(Visit visit);
  Visit withBoxes(Visit visit);
  bool isLeaf(const Visit& visit) const { return volumes_[visit.a].isLeaf() && volumes_[visit.b].isLeaf(); }
  void divide(const Visit& visit, double limit);

  void considerStates(const std::vector<SubjectPair>& pairs, RobotMinimum& answer);
  TimeOfContact contactOf(const Visit& visit, const MotionQuestion& question, double latest);
  MinimumOverMotion minimumOf(const Visit& visit, const MotionQuestion& question, double upper_bound);
  PairProximity found(const Visit& visit, SignedDistance result, double time);

  const std::shared_ptr<const SceneModel> model_;
  const Volumes volumes_;
  Scene scene_;  ///< at one time
  std::vector<MovingSubjects> subjects_;
  std::optional<PosesInTime> poses_;
  Order order_ = Order::Nearest;
  std::vector<Visit> queue_;  ///< a heap
};

}  // namespace proximity_server
