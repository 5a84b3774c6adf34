#pragma once

#include "node/robot/robot.h"
#include "proximity_server/ModelInfo.h"
#include "proximity_server/Proximity.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/RayHit.h"
#include "proximity_server/ShapeRef.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/points/ray_search.h"
#include "proximity_server/scene/query/question.h"
#include "system/numbers.h"

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <string>

// Converts answers of the scene into messages, without any computation of distances. Unknown numbers become NaN.

namespace proximity_server::node {

/// The robot and the objects of the scene that answered: the links and objects that the numbers in its answer stand
/// for.
struct RobotAndObjects {
  RobotAndObjects(const scene::RobotModel& of_robot, const scene::Objects* all = nullptr)  // NOLINT: implicit
      : robot(of_robot), objects(all) {}

  const scene::RobotModel& robot;
  const scene::Objects* objects;  ///< nullptr if the scene has none
};

RayHit toMessage(const RobotAndObjects& model, const scene::Ray& ray, const scene::RayHit& hit);

/// Converts a pair. `poses` are the poses of the scene that answered; they transform the points into the frames of the
/// links. The gradient stays empty, and the guaranteed distance is the lower bound.
Proximity toMessage(const RobotAndObjects& model, const scene::BodyPoses& poses, const scene::PairProximity& pair,
                    const scene::Question& question);

/// Writes a pair into an existing message. It allocates nothing if the strings of the message have enough capacity.
void assign(Proximity& message, const RobotAndObjects& model, const scene::BodyPoses& poses,
            const scene::PairProximity& pair, const scene::Question& question);

/// Writes the names of a link, <collision> or object into an existing message.
void assign(ShapeRef& message, const RobotAndObjects& model, const scene::ShapeRef& ref);

/// Makes the message name no link, shape or object.
void clear(ShapeRef& message);

/// Reserves memory for names of this many characters.
void reserveNames(ShapeRef& message, std::size_t characters);

/// A pair about which nothing is known.
Proximity unknownProximity();
void assignUnknown(Proximity& message);

/// A pair without names that is proven to be farther apart than `threshold` [m].
Proximity beyondThreshold(double threshold);

/// NOT_CONVERGED if the bounds are wider than the tolerance, else OK. The result must not be Status::Unknown.
std::int8_t statusCode(const narrowphase::SignedDistance& result);

ModelInfo toMessage(const Robot& robot, const ros::Time& loaded);

/// Fills the counters of a message, which tell how the distances of the pairs of a question were found.
template <class Message>
void assignCounts(Message& message, const scene::PairCounts& counts) {
  message.pairs_total = static_cast<std::uint32_t>(counts.total);
  message.pairs_unknown = static_cast<std::uint32_t>(counts.unknown);
  message.pairs_at_rest = static_cast<std::uint32_t>(counts.at_rest);
  message.pairs_by_motion = static_cast<std::uint32_t>(counts.by_motion);
  message.pairs_by_bounds = static_cast<std::uint32_t>(counts.by_bounds);
  message.pairs_computed = static_cast<std::uint32_t>(counts.computed);
}

}  // namespace proximity_server::node
