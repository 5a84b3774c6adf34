#pragma once

#include "chance.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"
#include "scene/posed_scene.h"
#include "scene/small_robots.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

namespace proximity_server::scene {

/// One state within an uncertainty: where in it each part is, relative to the largest. No factor is above 1, and no
/// vector is longer.
struct StateWithin {
  struct Frame {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
  };
  std::vector<double> positions;     ///< by joint
  std::vector<Frame> frames, bases;  ///< by joint; by robot
  std::vector<Frame> objects;        ///< by number
};

/// Half of the states are corners, where all is at its largest.
inline StateWithin someStateWithin(const RobotModel& robot, const Objects* objects, Chance& chance) {
  const bool is_corner = chance.below(2) == 0;
  const auto part = [&] { return is_corner ? 1.0 : chance.between(0.0, 1.0); };
  const auto frames = [&](std::size_t count) {
    std::vector<StateWithin::Frame> some(count);
    for (auto& frame : some) frame = {part() * chance.direction(), part() * chance.direction()};
    return some;
  };
  StateWithin state{{},
                    frames(robot.joints.size()),
                    frames(robot.robots.size()),
                    frames(static_cast<std::size_t>(objects ? objects->numberLimit() : 0))};
  for (std::size_t i = 0; i < robot.joints.size(); ++i) state.positions.push_back(chance.eitherSign(part()));
  return state;
}

/// The smallest distance(state) of so many states.
template <typename Distance>
double smallestOfSome(int count, const RobotModel& robot, const Objects* objects, Chance& chance,
                      const Distance& distance) {
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) smallest = std::min(smallest, distance(someStateWithin(robot, objects, chance)));
  return smallest;
}

/// The smallest distance(state) of corners of the joints on the way to the worst one.
template <typename Distance>
double smallestOfCorners(const RobotModel& robot, const Objects* objects, Chance& chance, const Distance& distance) {
  StateWithin corner = someStateWithin(robot, objects, chance);
  for (double& position : corner.positions) position = std::copysign(1.0, position);
  double smallest = distance(corner);
  for (double& position : corner.positions) {
    position = -position;
    const double other = distance(corner);
    if (other > smallest) position = -position;
    smallest = std::min(smallest, other);
  }
  return smallest;
}

/// The motion of a frame with this origin.
inline Eigen::Isometry3d motionWithin(const PoseUncertainty& most, const StateWithin::Frame& frame,
                                      const Eigen::Vector3d& origin) {
  const double angle = most.angle * frame.turn.norm();
  const Eigen::Vector3d axis = frame.turn.norm() > 0.0 ? frame.turn.normalized() : Eigen::Vector3d::UnitX();
  return Eigen::Translation3d(origin + most.translation * frame.translation) * Eigen::AngleAxisd(angle, axis) *
         Eigen::Translation3d(-origin);
}

/// The poses in a state, joint by joint, from poses that are all known.
inline BodyPoses posesWithin(const RobotModel& robot, const BodyPoses& poses, const Uncertainty& uncertainty,
                             const StateWithin& state) {
  BodyPoses result(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Body& body = robot.bodies[i];
    if (body.joint < 0) {
      result[i] =
          motionWithin(uncertainty.bases[body.robot], state.bases[body.robot], poses[i]->translation()) * *poses[i];
      continue;
    }
    const Joint& joint = robot.joints[body.joint];
    const Joint::Mimic leader = robot.leaderOf(body.joint);
    const Eigen::Isometry3d parent_T_child = poses[body.parent]->inverse() * *poses[i];
    const Eigen::Vector3d origin =
        hasOnePosition(joint)
            ? Eigen::Vector3d((robot.links[joint.parent_link].body_T_link * joint.parent_T_joint).translation())
            : Eigen::Vector3d(parent_T_child.translation());
    const double by = leader.multiplier * uncertainty.positions[leader.joint] * state.positions[leader.joint];
    result[i] = *result[body.parent] * motionWithin(uncertainty.frames[body.joint], state.frames[body.joint], origin) *
                parent_T_child * (hasOnePosition(joint) ? jointMotion(joint, by) : Eigen::Isometry3d::Identity());
  }
  return result;
}

/// The objects in a state, with the same numbers.
inline std::shared_ptr<const Objects> objectsWithin(const Objects& objects, const Uncertainty& uncertainty,
                                                    const StateWithin& state) {
  std::vector<ObjectChange> changes;
  for (const int number : objects.numbers()) {
    Object object = *objects.object(number);
    const auto move = [&](Eigen::Isometry3d& pose) {
      pose = motionWithin(uncertainty.ofObject(object.id), state.objects[number], pose.translation()) * pose;
    };
    if (auto* fixed = std::get_if<Fixed>(&object.placement))
      move(fixed->world_T_object);
    else if (auto* moving = std::get_if<Moving>(&object.placement))
      move(moving->frame_T_object);
    else
      move(std::get<Attached>(object.placement).link_T_object);
    changes.push_back(ReplaceObject{object});
  }
  return std::make_shared<const Objects>(objects.changed(changes));
}

/// The smallest distance(state) [m] that a search along one joint after the other finds.
template <typename Distance>
double smallestOfSearch(const RobotModel& robot, Chance& chance, const Distance& distance) {
  StateWithin state = someStateWithin(robot, nullptr, chance);
  double smallest = distance(state);
  for (bool is_better = true; is_better;) {
    is_better = false;
    for (double& position : state.positions) {
      double best = position;
      for (const double other : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
        position = other;
        const double found = distance(state);
        if (found > smallest - 1e-12) continue;
        smallest = found;
        best = other;
        is_better = true;
      }
      position = best;
    }
  }
  return smallest;
}

/// The loss of a guaranteed distance, divided by the loss of the worst state that searches find or that is known. A
/// micrometre is added to both losses.
///
/// Units:   `guaranteed` and `worst` in m: the smallest distance that is known, at most that of the pair.
inline double lossFactor(const PairProximity& pair, double guaranteed, double worst, PosedScene& within,
                         const BodyPoses& poses, const Uncertainty& uncertainty, Chance& chance) {
  constexpr double kLittle = 1e-6;  // [m]
  const RobotModel& robot = within.model().robot;
  const auto in = [&](const StateWithin& state) {
    within.update(posesWithin(robot, poses, uncertainty, state));
    return within.proximity(pair.asked).result.distance;
  };
  for (int i = 0; i < 3; ++i) worst = std::min(worst, smallestOfSearch(robot, chance, in));
  return (pair.result.distance - guaranteed + kLittle) / (pair.result.distance - worst + kLittle);
}

/// [m] What the surfaces of a pair may be outside of their geometry.
inline double swellingOf(const Uncertainty& uncertainty, const ShapeRefPair& pair) {
  return (pair.a.isLink() ? uncertainty.swellings[pair.a.link()] : 0.0) +
         (pair.b.isLink() ? uncertainty.swellings[pair.b.link()] : 0.0);
}

/// An uncertainty with random entries up to `angle` [rad] and `length` [m]; some are 0.
inline Uncertainty someUncertainty(const RobotModel& robot, double angle, double length, Chance& chance) {
  Uncertainty uncertainty(robot);
  const auto upTo = [&](double most) { return chance.below(3) == 0 ? 0.0 : chance.between(0.0, most); };
  const auto frame = [&] { return PoseUncertainty{upTo(length), upTo(angle)}; };
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    if (hasOnePosition(robot.joints[i]))
      uncertainty.positions[i] = upTo(robot.joints[i].type == Joint::Type::Prismatic ? length : angle);
    if (chance.below(2) == 0) uncertainty.frames[i] = frame();
  }
  for (PoseUncertainty& base : uncertainty.bases) base = frame();
  for (double& swelling : uncertainty.swellings) swelling = upTo(0.1 * length);
  uncertainty.objects = frame();
  uncertainty.own_objects["crate"] = frame();
  return uncertainty;
}

}  // namespace proximity_server::scene
