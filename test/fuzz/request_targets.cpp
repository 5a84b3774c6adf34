#include "fuzz/request_bytes.h"
#include "fuzz/require.h"
#include "fuzz/targets.h"
#include "node/answers/gradients.h"
#include "node/answers/motions.h"
#include "node/objects/apply_objects.h"
#include "node/objects/object_store.h"
#include "node/robot/config.h"
#include "node/robot/load_config.h"
#include "node/services/joint_requests.h"
#include "node/services/motion_requests.h"
#include "node/services/pair_questions.h"
#include "node/services/queries.h"
#include "node/services/requests.h"
#include "node/services/trajectory_requests.h"
#include "node/sources/tracked_points.h"
#include "proximity_server/MinimumDistanceRequest.h"
#include "proximity_server/QueryConfigurationRequest.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "robots/robots.h"
#include "scene/files.h"
#include "system/durations.h"

#include <xmlrpcpp/XmlRpcValue.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>

namespace proximity_server::fuzz {

using namespace narrowphase;
using namespace scene;
using namespace node;
namespace {

const std::vector<std::string> kNames{"",     "base",     "arm",   "hand",  "tool", "finger", "ball",  "slab",
                                      "knob", "shoulder", "wrist", "mount", "grip", "free",   "upper", "part"};

std::shared_ptr<const Robot> armWith(const Config& config) {
  return std::make_shared<const Robot>(robotText("arm_with_hand.urdf"), robotText("arm_with_hand.srdf"), config);
}

/// The arm with a ball, the object "part", beside it.
const Robot& arm() {
  static const std::shared_ptr<const Robot> robot = [] {
    const auto alone = armWith(Config());
    const Eigen::Isometry3d beside(Eigen::Translation3d(0.6, 0.0, 0.6));
    const Object part = makeObject("part", {{Shape(Sphere{0.1})}}, Fixed{beside});
    const auto none = alone->objects().get().all;
    alone->objects().set({std::make_shared<const Objects>(none->changed({AddObject{part}})), 1});
    return alone;
  }();
  return *robot;
}

/// Joints that a request leaves open are not known, as without tf.
JointSnapshot nothingFromTf() {
  JointSnapshot nothing;
  nothing.joints.resize(arm().robotModel().joints.size());
  return nothing;
}

BodyPoses posesAt(const JointValues& positions) { return posesInRoot(arm(), positions, nothingFromTf()); }

BodyPoses posesAtZero() {
  return posesAt(completed(JointValues(arm().robotModel().joints.size()), MissingJoints::AtZero));
}

void checkBounds(const Proximity& pair) {
  require(!(pair.lower_bound > pair.upper_bound), "the lower bound is below the upper one");
  require(!(pair.guaranteed > pair.lower_bound), "the guaranteed distance is not above the lower bound");
  for (const double entry : pair.gradient) require(std::isfinite(entry), "a gradient is finite, or empty");
}

void checkAnswer(const StateProximity& answer) {
  checkBounds(answer.minimum);
  for (const Proximity& pair : answer.pairs) checkBounds(pair);
}

void askAt(const BodyPoses& poses, const QueryPairsRequest& request, std::size_t states) {
  const Question question = questionOf(arm(), request);
  const RequestedPairs pairs = pairsOf(arm(), request);
  requireAnswersWithinBatch(arm(), request, pairs.size(), states);
  pairs.bodies();
  const ScenePool::Lease scenes = pairs.borrowScenes();
  scenes->state.set(poses);
  const QueryStatus status;
  GuaranteedDistances* const guaranteed =
      guaranteedWithin(uncertaintyOf(arm(), request.uncertainty), *scenes, question);
  checkAnswer(askPairs(arm(), *scenes, {poses, status}, pairs, request, question, guaranteed));
}

void ask(const QueryPairsRequest& request) { askAt(posesAtZero(), request, 1); }

void ask(const MinimumDistanceRequest& request) {
  pairsOf(arm(), request.a, request.b, filterOf(request.ignore_filter));
  thresholdOrNone(request.threshold);
}

void ask(const QueryConfigurationRequest& request) {
  QueryPairsRequest in_each;
  in_each.a = request.a;
  in_each.b = request.b;
  in_each.group = request.group;
  in_each.mode = request.mode;
  in_each.k = request.k;
  in_each.threshold = request.threshold;
  in_each.ignore_filter = request.ignore_filter;
  in_each.want_gradient = request.want_gradient;
  const MissingJoints missing = missingJoints(request.missing_joints);
  for (const sensor_msgs::JointState& state : request.states) {
    const std::vector<int> joints = jointsNamed(arm().robotModel(), state.name, "state");
    const JointValues values = valuesOf(arm().robotModel(), joints, state.position, "position", "state");
    askAt(posesAt(completed(values, missing)), in_each, request.states.size());
  }
}

void ask(const QueryPointsRequest& request) {
  const RequestedPairs shapes = shapesOf(arm(), request.shapes, Unnamed::RobotWithHeld);
  Points points{{}, request.radii};
  for (const ShapeRefPair& shape : *shapes.list()) points.shapes.push_back(shape.a);
  for (const geometry_msgs::Point& point : request.points) points.centres.emplace_back(point.x, point.y, point.z);
  Question question = questionOf(arm());
  question.threshold = thresholdOrNone(request.threshold);
  const ScenePool::Lease scenes = shapes.borrowScenes();
  scenes->state.set(posesAtZero());
  try {
    for (const PairProximity& found : scenes->points().closest(scenes->state, points, question))
      require(!(found.result.lower_bound > found.result.upper_bound), "the lower bound is below the upper one");
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
}

void ask(const QueryRaysRequest& request) {
  const RequestedPairs shapes = shapesOf(arm(), request.shapes, Unnamed::Everything);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < std::min(request.origins.size(), request.directions.size()); ++i) {
    const auto& from = request.origins[i];
    const auto& along = request.directions[i];
    rays.push_back({{from.x, from.y, from.z}, {along.x, along.y, along.z}});
    if (i < request.ranges.size()) rays.back().range = request.ranges[i];
  }
  const ScenePool::Lease scenes = shapes.borrowScenes();
  scenes->state.set(posesAtZero());
  try {
    for (const scene::RayHit& hit : scenes->rays().firstHits(scenes->state, rays))
      require(!(hit.free > hit.distance), "nothing is hit where the ray is proven to be free");
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
}

/// A search that ends after a millisecond, whatever was asked.
void search(const RequestedPairs& pairs, const Motion& motion, MotionQuestion question) {
  question.deadline = system::deadlineIn(1e-3);
  const ScenePool::Lease scenes = pairs.borrowScenes();
  MotionSearch& scene = scenes->motions();
  const RobotTimeOfContact contact = scene.timeOfContact(pairs.asked(), motion, question);
  require(contact.t_free >= 0.0 && contact.t_free <= 1.0, "what is proven free lies within the motion");
  const RobotMinimum minimum = scene.minimum(pairs.asked(), motion, question);
  require(minimum.lower_bound <= minimum.upper_bound, "the lower bound is below the upper one");
}

const PairDistances kStop(0.02, 0.02);

void ask(const FirstContactRequest& request) {
  const MotionQuestion question = motionQuestion(request.contact_distance, request.tolerance, kStop);
  timeBudget(arm(), request.time_budget);
  positive(request.horizon, "horizon");
  const RequestedPairs pairs = pairsOf(arm(), request.a, request.b, filterOf(request.ignore_filter));
  PoseSnapshot start;
  start.poses = posesAtZero();
  search(pairs, motionOf(arm(), start, pairs.frames(), {}, request).limited.motion, question);
}

void ask(const QueryTrajectoryRequest& request) {
  const MotionQuestion question = motionQuestion(request.contact_distance, request.tolerance, kStop);
  timeBudget(arm(), request.time_budget);
  const RequestedPairs pairs = pairsOf(arm(), request.a, request.b, filterOf(request.ignore_filter));
  const WayPoints way = wayPointsOf(arm(), request);
  const std::vector<double> tracking_error = trackingErrorOf(arm(), way, request);
  for (std::size_t i = 0; i + 1 < way.points.size(); ++i) {
    const TrajectoryPoint &from = way.points[i], &to = way.points[i + 1];
    try {
      const SplineSegment spline(arm().robotModel(), from, to);
      require(spline.at(1.0).size() == to.positions.size(), "a spline has all joints");
      spline.beyondLimits(arm().robotModel());
      const BodyPoses poses = posesAt(way.valuesAt(from.positions));
      Motion motion(arm().robotModel(), inRoot(arm(), poses), from, to, tracking_error);
      motion.carryObjects(objectFramesInRoot(arm(), poses, pairs.frames(), {}));
      search(pairs, motion, question);
    } catch (const std::invalid_argument&) {  // numbers that are too far apart
    }
  }
}

/// With a few boxes for each pair, and never from tf, which would be waited for.
void ask(ProveJointBoxRequest request) {
  request.most_boxes = request.most_boxes % 4 + 1;
  if (request.missing_joints == ProveJointBoxRequest::FROM_TF) request.missing_joints = ProveJointBoxRequest::ZERO;
  ros::Time::init();  // the answer reads the clock
  TfPoses tf;
  const ProveJointBoxResponse response = answer(arm(), tf, request);
  require(response.status.code != QueryStatus::INTERNAL_ERROR, "a bad box is no defect of the node");
  require(response.success || !response.status.message.empty(), "a refusal says why");
  for (const PairProof& proof : response.pairs) {
    require(!response.proven || proof.outcome == PairProof::PROVEN, "all is proven only if each pair is");
    require(!(proof.lower_bound > proof.closest_upper_bound), "no state is nearer than what is proven");
  }
}

template <class Request>
void askOf(std::string_view bytes) {
  Request request;
  RequestBytes(bytes, kNames).next(request);
  try {
    ask(request);
  } catch (const RequestError& error) {
    require(error.status().code != QueryStatus::OK && !error.status().message.empty(), "a refusal says why");
  }
}

/// Names of objects of the arm, of links and frames where they may be, and of files that are not there.
const std::vector<std::string> kObjectNames{
    "", "part", "box", "*", "arm", "hand", "tool", "finger", "camera", "package://nowhere/a.stl", "base"};

Eigen::Isometry3d poseOfFrame(const Robot& /*robot*/, const std::string& frame) {
  if (frame.size() % 5 == 4) throw ChangeError(QueryStatus::TF_UNAVAILABLE, "frame has no pose");
  return Eigen::Translation3d(0.1 * static_cast<double>(frame.size()), 0.0, 0.3) *
         Eigen::AngleAxisd(static_cast<double>(frame.size()), Eigen::Vector3d::UnitX());
}

const std::shared_ptr<const Robot>& armWithoutMeshFiles() {
  static const TemporaryFiles none;
  static const std::shared_ptr<const Robot> robot = [] {
    Config config;
    config.allowed_mesh_roots = {std::filesystem::path(none.write("empty/a", "")).parent_path()};
    config.model.mesh_time_budget = 1e-3;
    return armWith(config);
  }();
  return robot;
}

/// Asks about all pairs with an object.
void checkAnswers(const std::shared_ptr<const Objects>& objects) {
  const Robot& robot = *armWithoutMeshFiles();
  const ScenePool::Lease scenes = robot.borrowScenes();
  scenes->state.set(objects);
  scenes->state.set(forwardKinematics(robot.robotModel(), std::vector<double>(robot.robotModel().joints.size(), 0.0)),
                    FramePoses(objects->frames().size(), Eigen::Isometry3d::Identity()));
  for (const PairProximity& pair : scenes->scene.all(scenes->state, robot.candidates()))
    require(!(pair.result.lower_bound > pair.result.upper_bound), "the lower bound is below the upper one");
}

/// Checks that the next start of the node has the objects of now.
void checkKeeping(const ObjectStore& store) {
  const ObjectStore::Snapshot now = store.snapshot();
  ObjectFile file = objectFileFrom(readYaml(yamlOf(now.file), "file"), "file");
  require(file.objects.size() == now.file.objects.size(), "all objects are kept");
  // Geometry of the very limits may lie beyond them after a rounding.
  for (const ObjectEdit& object : file.objects) require(!object.shapes.empty(), "all shapes are kept");
}

}  // namespace

void tryObjects(const std::string& bytes) {
  const std::shared_ptr<const Robot>& robot = armWithoutMeshFiles();
  const auto none = robot->objects().get();
  ObjectStore store(robot, 7, poseOfFrame);
  RequestBytes stream(bytes, kObjectNames);
  for (int message = 0; message < 2; ++message) {
    ApplyObjectsRequest request;
    stream.next(request);
    const ObjectList before = store.list();
    const ApplyObjectsResponse response = answer(store, request);
    require(response.status.code != QueryStatus::INTERNAL_ERROR, "bad objects are no defect of the node");
    require(response.success || !response.status.message.empty(), "a refusal says why");
    require(response.success || store.list().objects.size() == before.objects.size(), "a refusal changes nothing");
  }
  checkAnswers(robot->objects().get().all);
  checkKeeping(store);
  robot->objects().set(none);
}

void tryCloud(const std::string& bytes) {
  if (bytes.empty()) return;
  static const std::vector<std::string> names{"x", "y", "z", "rgb", ""};
  const std::string_view behind = std::string_view(bytes).substr(1);
  const std::string_view layout = behind.substr(0, static_cast<unsigned char>(bytes[0]));
  sensor_msgs::PointCloud2 cloud;
  RequestBytes(layout, names).next(cloud);
  cloud.data.assign(behind.begin() + static_cast<std::ptrdiff_t>(layout.size()), behind.end());
  try {
    const std::vector<Eigen::Vector3d> returns = returnsOf(cloud);
    require(returns.empty() || returns.size() <= cloud.data.size() / cloud.point_step,
            "each point has bytes of its own");
    for (const Eigen::Vector3d& point : returns) require(point.allFinite(), "a return is finite");
    require(pointsOf(cloud) == returns, "both readers find the same points");
  } catch (const std::invalid_argument& error) {
    require(!std::string(error.what()).empty(), "a refusal says why");
  }
}

void tryRequest(const std::string& bytes) {
  if (bytes.empty()) return;
  const std::string_view body = std::string_view(bytes).substr(1);
  switch (bytes[0]) {
    case 'm':
      return askOf<MinimumDistanceRequest>(body);
    case 'p':
      return askOf<QueryPairsRequest>(body);
    case 'q':
      return askOf<QueryPointsRequest>(body);
    case 'r':
      return askOf<QueryRaysRequest>(body);
    case 'c':
      return askOf<QueryConfigurationRequest>(body);
    case 't':
      return askOf<QueryTrajectoryRequest>(body);
    case 'j':
      return askOf<ProveJointBoxRequest>(body);
    default:
      return askOf<FirstContactRequest>(body);
  }
}

void tryParameters(const std::string& bytes) {
  XmlRpc::XmlRpcValue values;
  int offset = 0;
  if (!values.fromXml(bytes, &offset)) return;
  try {
    const Config config = configFrom(values, "/node");
    require(config.tolerance > 0.0 && config.max_batch >= 1, "a parameter is within its range");
  } catch (const std::invalid_argument& error) {
    require(std::string(error.what()).rfind("parameter /node/", 0) == 0, "an error names the parameter");
  }
}

}  // namespace proximity_server::fuzz
