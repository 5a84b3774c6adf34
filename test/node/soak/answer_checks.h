#pragma once

#include <proximity_server/Clearance.h>
#include <proximity_server/FirstContact.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/PenetrationDepth.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/QueryTrajectory.h>
#include <proximity_server/SeparationAxis.h>
#include "node/load/moving_robot.h"
#include "scene/posed_scene.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::node {

using namespace scene;

struct SaidContact;
struct SaidMinimum;

/// Says what is wrong with an answer; empty if nothing is.
using Verdict = std::string;

/// Checks what the node says about a MovingRobot against the library by itself: the stamp of an answer, or the states
/// in the request, tell where every joint stands. Both sides enclose the true distance, so their bounds must meet. Not
/// thread-safe.
class AnswerChecks {
 public:
  explicit AnswerChecks(const std::shared_ptr<const SceneModel>& model);

  /// The objects that the node has from now on, none at first. Their frames are those of links.
  void use(const std::shared_ptr<const Objects>& objects) { scene_.use(objects); }

  // These check answers with success.

  Verdict check(const MinimumDistanceRequest& request, const MinimumDistanceResponse& response);
  Verdict check(const SeparationAxisRequest& request, const SeparationAxisResponse& response);
  Verdict check(const PenetrationDepthRequest& request, const PenetrationDepthResponse& response);
  Verdict check(const QueryPairsRequest& request, const QueryPairsResponse& response);
  /// Every state names every joint.
  Verdict check(const QueryConfigurationRequest& request, const QueryConfigurationResponse& response);
  /// Moves joints, not links. Also without success, where the time budget ended or the bounds are wide.
  Verdict check(const FirstContactRequest& request, const FirstContactResponse& response);
  /// Names every joint. Also without success, where the time budget ended or the bounds are wide.
  Verdict check(const QueryTrajectoryRequest& request, const QueryTrajectoryResponse& response);

  /// A cycle that is not INVALID, with the thresholds [m] of its levels and of its list.
  struct Levels {
    double warn, stop, listed;
    int most_listed;
  };
  Verdict check(const Clearance& clearance, const Levels& levels);

 private:
  /// A pair, or with an empty `a` all that are checked, objects included.
  struct Asked {
    const proximity_server::ShapeRef &a, &b;
  };
  using StateAt = std::function<std::vector<double>(double time)>;

  void place(const ros::Time& stamp);
  void placeIn(const std::vector<double>& positions);
  std::vector<double> positionsOf(const sensor_msgs::JointState& state) const;
  scene::ShapeRef refOf(const proximity_server::ShapeRef& ref) const;
  PairProximity closest(const proximity_server::ShapeRef& a, const proximity_server::ShapeRef& b);
  ShapeRefPair pairOf(const proximity_server::ShapeRef& a, const proximity_server::ShapeRef& b) const;
  Verdict checkKind(PairKind kind, const Proximity& said);
  PairProximity closestIn(const std::vector<double>& positions, const Asked& asked);
  Verdict checkNumberBelow(double threshold, std::size_t said);
  Verdict checkPosed(const QueryPairsRequest& request, const std::vector<Proximity>& said);
  Verdict checkContact(const StateAt& state_at, const Asked& asked, double contact_distance, const SaidContact& said);
  Verdict checkMinimum(const StateAt& state_at, const Asked& asked, const SaidMinimum& said);

  MovingRobot robot_;
  PosedScene scene_;
};

}  // namespace proximity_server::node
