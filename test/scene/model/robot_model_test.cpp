#include "proximity_server/scene/model/robot_model.h"

#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <sstream>
#include <thread>
#include <utility>

namespace proximity_server::scene::robot_model_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const double kPi = std::acos(-1.0);

// --- URDFs in words

/// With the attributes of its origin, or without an origin.
std::string collision(const std::string& shape, const std::string& origin = "") {
  return "<collision>" + (origin.empty() ? "" : "<origin " + origin + "/>") + "<geometry>" + shape +
         "</geometry></collision>";
}

const std::string kUnitBox = collision("<box size='1 1 1'/>");

/// A resolver for robots without meshes.
std::string noMesh(const std::string& uri) { throw std::invalid_argument(uri + ": no such mesh"); }

RobotModel load(const std::string& body, const ModelOptions& options = {}) {
  return loadRobotModel(urdfOf(body, "test"), noMesh, options);
}

std::string errorOfLoading(const std::string& body, const ModelOptions& options = {}) {
  return errorOf([&] { load(body, options); });
}

std::vector<std::string> warningsThatSay(const std::string& what, const RobotModel& model) {
  std::vector<std::string> found;
  for (const std::string& warning : model.warnings)
    if (warning.find(what) != std::string::npos) found.push_back(warning);
  return found;
}

void expectSays(const std::string& said, const std::string& what) {
  EXPECT_NE(said.find(what), std::string::npos) << "\"" << said << "\" does not mention " << what;
}

void expectWarns(const RobotModel& model, const std::string& what) {
  std::string all;
  for (const std::string& warning : model.warnings) all += warning + "\n";
  expectSays(all, what);
}

void expectNear(const Isometry3d& pose, const Isometry3d& expected) {
  EXPECT_TRUE(pose.isApprox(expected, 1e-12)) << pose.matrix() << "\n\nexpected\n" << expected.matrix();
}

// --- names

TEST(NearestName, HasTheFewestEdits) {
  EXPECT_EQ(nearestName("elbov", {"shoulder", "elbow", "wrist"}), "elbow");
  EXPECT_EQ(nearestName("l_wrist_link", {"r_wrist_flex_link", "l_wrist_links"}), "l_wrist_links");
  EXPECT_EQ(nearestName("elbow", {}), "");
  EXPECT_EQ(nearestName("elbow", {"wrist", "elbow_flex_joint"}), "elbow_flex_joint");
  EXPECT_EQ(nearestName("elbow" + std::string(50000000, 'x'), {"shoulder", "elbow"}), "elbow");
}

TEST(NearestName, IsNoneWhereNoneIsNear) {
  EXPECT_EQ(nearestName("rate", {"warn_distance", "threshold"}), "");
  EXPECT_EQ(nearestName("zz", {"base"}), "");
  EXPECT_EQ(nearestName("a", {"b", "bc"}), "");
  EXPECT_EQ(unknownName("zz", {"base"}), "\"zz\"");
  EXPECT_EQ(didYouMean("bse", {"base"}), ": did you mean 'base'?");
  EXPECT_EQ(didYouMean("zz", {"base"}), "");
}

TEST(MisspelledName, IsNearAndUnknown) {
  const std::vector<std::string> known = {"group", "disable_collisions"};
  EXPECT_EQ(misspelledName("disable_collision", known), "disable_collisions");
  EXPECT_EQ(misspelledName("disabled-colision", known), "disable_collisions");
  EXPECT_EQ(misspelledName("groop", known), "group");
  EXPECT_EQ(misspelledName("group", known), "");
  EXPECT_EQ(misspelledName("group_state", known), "");
  EXPECT_EQ(misspelledName("group", {}), "");
}

// --- visual geometry

std::string visual(const std::string& geometry) {
  return "<visual name='skin'><geometry>" + geometry + "</geometry></visual>";
}

/// Four links: "a" has collision and visual geometry, "b" and "c" have visual geometry only, "d" has none.
const std::string kDressed = link("a", collision("<box size='1 1 1'/>") + visual("<box size='2 2 2'/>")) +
                             link("b", visual("<sphere radius='0.5'/>") + visual("<box size='1 2 3'/>")) +
                             link("c", visual("<sphere radius='0.25'/>")) + link("d") +
                             joint("to_b", "fixed", "a", "b") + joint("to_c", "fixed", "a", "c") +
                             joint("to_d", "fixed", "a", "d");

TEST(CollisionFromVisual, IsOfTheNamedLinksWithoutCollision) {
  ModelOptions options;
  options.collision_from_visual = {"a", "b"};
  const RobotModel model = load(kDressed, options);
  ASSERT_EQ(model.pieces.size(), 3U);
  EXPECT_EQ(model.pieces[0].shape.halfExtents(), Vector3d(0.5, 0.5, 0.5)) << "its collision geometry stays";
  EXPECT_EQ(model.collisions[0].description, "box 1 x 1 x 1");
  EXPECT_EQ(model.collisions[1].description, "sphere, radius 0.5, of its <visual>");
  EXPECT_EQ(model.collisions[1].name, "skin");
  EXPECT_EQ(model.collisions[2].link, model.findLink("b"));
  expectWarns(model, "Seen, but not checked, as they have no <collision>: 1 of 3 links with a <visual>: c. ");
}

TEST(CollisionFromVisual, OfAllLinksLeavesNone) {
  ModelOptions options;
  options.collision_from_visual = {kAllLinks};
  const RobotModel model = load(kDressed, options);
  EXPECT_EQ(model.pieces.size(), 4U);
  EXPECT_TRUE(model.warnings.empty()) << model.warnings[0];
}

TEST(CollisionFromVisual, WithoutItTheLoadNamesWhatIsSeenOnly) {
  const RobotModel model = load(kDressed);
  EXPECT_EQ(model.pieces.size(), 1U);
  ASSERT_EQ(model.warnings.size(), 1U);
  expectSays(model.warnings[0], "2 of 3 links with a <visual>: b, c. The parameter collision_from_visual");
}

TEST(CollisionFromVisual, ThatCannotBeUsedIsRefusedByLink) {
  ModelOptions options;
  options.collision_from_visual = {"bb"};
  expectSays(errorOfLoading(kDressed, options), "collision_from_visual: no link \"bb\"");
  options.collision_from_visual = {kAllLinks};
  expectSays(errorOfLoading(link("a", visual("<sphere radius='-1'/>")), options), "\"a\"");
  expectSays(errorOfLoading(link("a", visual("<mesh filename='package://a/b.stl'/>")), options),
             "link \"a\", <collision> 1, of its <visual>: ");
  EXPECT_EQ(errorOfLoading(link("a", visual("<sphere radius='-1'/>"))), "") << "unless it is asked for";
}

// --- shapes

TEST(RobotModel, PrimitivesHaveTheirSizesAndPoses) {
  const RobotModel model = load(link("a", collision("<box size='1 2 3'/>", "xyz='1 2 3' rpy='0 0 1.5'") +
                                              collision("<sphere radius='0.5'/>") +
                                              collision("<cylinder radius='0.1' length='0.4'/>", "xyz='5 0 0'")));
  ASSERT_EQ(model.pieces.size(), 3U);
  EXPECT_EQ(model.pieces[0].shape.kind(), Shape::Kind::Box);
  EXPECT_EQ(model.pieces[0].shape.halfExtents(), Vector3d(0.5, 1.0, 1.5));
  expectNear(model.pieces[0].body_T_piece, at(1, 2, 3) * Isometry3d(Eigen::AngleAxisd(1.5, Vector3d::UnitZ())));
  EXPECT_EQ(model.pieces[1].shape.kind(), Shape::Kind::Point);
  EXPECT_EQ(model.pieces[1].shape.margin(), 0.5);
  EXPECT_EQ(model.pieces[2].shape.kind(), Shape::Kind::Cylinder);
  EXPECT_EQ(model.pieces[2].shape.halfExtents(), Vector3d(0.1, 0.1, 0.2));
  EXPECT_EQ(model.collisions[0].description, "box 1 x 2 x 3");
}

TEST(RobotModel, RollPitchYawTurnAboutFixedAxes) {
  const RobotModel model = load(link("a", collision("<box size='1 1 1'/>", "rpy='0.1 0.2 0.3'")));
  expectNear(model.pieces.at(0).body_T_piece,
             Isometry3d(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.2, Vector3d::UnitY()) *
                        Eigen::AngleAxisd(0.1, Vector3d::UnitX())));
}

TEST(RobotModel, EveryCollisionOfALinkCounts) {
  std::string eight;
  for (int i = 0; i < 8; ++i) eight += kUnitBox;
  const RobotModel model = load(link("a", eight));
  ASSERT_EQ(model.collisions.size(), 8U);
  EXPECT_EQ(model.collisions[7].number, 8);
  EXPECT_EQ(model.bodies[0].pieces.size(), 8U);
}

TEST(RobotModel, CollisionKeepsItsName) {
  const RobotModel model =
      load(link("a", "<collision name='lid'><geometry><box size='1 1 1'/></geometry></collision>" + kUnitBox));
  EXPECT_EQ(model.collisions[0].name, "lid");
  EXPECT_EQ(model.collisions[1].name, "");
}

TEST(RobotModel, BrokenVisualAndInertialDoNotMatter) {
  const RobotModel model =
      load("<material/>" + link("a", "<visual/><inertial><mass value='heavy'/></inertial>" + kUnitBox));
  EXPECT_EQ(model.pieces.size(), 1U);
  EXPECT_TRUE(model.warnings.empty());
}

// --- capsules

const std::string kUpright = "<cylinder radius='0.1' length='0.4'/>";
const std::string kBall = "<sphere radius='0.1'/>";

TEST(RobotModel, CylinderWithEqualSpheresAtBothEndsIsACapsule) {
  const RobotModel model = load(link("a", collision(kBall, "xyz='1 0 -0.2'") + collision(kUpright, "xyz='1 0 0'") +
                                              collision(kBall, "xyz='1 0 0.2'") + kUnitBox));
  ASSERT_EQ(model.bodies[0].pieces.size(), 2U);
  const Piece& capsule = model.pieces[model.bodies[0].pieces[0]];
  EXPECT_EQ(capsule.shape.kind(), Shape::Kind::Segment);
  EXPECT_EQ(capsule.shape.halfExtents(), Vector3d(0, 0, 0.2));
  EXPECT_EQ(capsule.shape.margin(), 0.1);
  expectNear(capsule.body_T_piece, at(1, 0, 0));
  EXPECT_EQ(model.collisions[capsule.collision].number, 2);
  expectSays(model.collisions[1].description, "capsule");
}

TEST(RobotModel, PartsOfACapsuleStillStandForThemselves) {
  const RobotModel model =
      load(link("a", collision(kUpright) + collision(kBall, "xyz='0 0 -0.2'") + collision(kBall, "xyz='0 0 0.2'")));
  ASSERT_EQ(model.collisions.size(), 3U);
  EXPECT_EQ(model.pieces[model.collisions[0].pieces.at(0)].shape.kind(), Shape::Kind::Cylinder);
  EXPECT_EQ(model.pieces[model.collisions[1].pieces.at(0)].shape.kind(), Shape::Kind::Point);
  EXPECT_EQ(model.bodies[0].pieces.size(), 1U);
}

TEST(RobotModel, TurnedCapsuleIsRecognisedWithinRounding) {
  // The cylinder's axis along x by a pitch of pi/2, far from the origin.
  const RobotModel model =
      load(link("a", collision(kUpright, "xyz='30 20 10' rpy='0 1.5707963267948966 0'") +
                         collision(kBall, "xyz='29.8 20 10'") + collision(kBall, "xyz='30.2 20 10'")));
  EXPECT_EQ(model.bodies[0].pieces.size(), 1U);
}

TEST(RobotModel, SphereBetweenTwoCylindersEndsBothCapsules) {
  const RobotModel model =
      load(link("a", collision(kUpright) + collision(kUpright, "xyz='0 0 0.4'") + collision(kBall, "xyz='0 0 -0.2'") +
                         collision(kBall, "xyz='0 0 0.2'") + collision(kBall, "xyz='0 0 0.6'")));
  EXPECT_EQ(model.bodies[0].pieces.size(), 2U);
}

TEST(RobotModel, CylinderIsNoCapsuleWhereASphereIsMissingSmallerOrOff) {
  const std::string below = collision(kBall, "xyz='0 0 -0.2'");
  for (const std::string& other : {std::string(), collision("<sphere radius='0.0999'/>", "xyz='0 0 0.2'"),
                                   collision(kBall, "xyz='0 0 0.2000001'")}) {
    const RobotModel model = load(link("a", collision(kUpright) + below + other));
    EXPECT_EQ(model.bodies[0].pieces.size(), model.collisions.size()) << other;
  }
}

TEST(RobotModel, SpheresOfAnotherLinkMakeNoCapsule) {
  const RobotModel model = load(link("a", collision(kUpright)) +
                                link("b", collision(kBall, "xyz='0 0 -0.2'") + collision(kBall, "xyz='0 0 0.2'")) +
                                joint("j", "fixed", "a", "b"));
  EXPECT_EQ(model.bodies[0].pieces.size(), 3U);
}

// --- padding

TEST(RobotModel, PaddingIsTheMargin) {
  ModelOptions options;
  options.default_padding = 0.01;
  options.link_padding["b"] = 0.05;
  const RobotModel model =
      load(link("a", kUnitBox) + link("b", collision(kBall) + kUnitBox) + joint("j", "fixed", "a", "b"), options);
  EXPECT_EQ(model.pieces[0].shape.margin(), 0.01);
  EXPECT_EQ(model.pieces[1].shape.margin(), 0.1 + 0.05);
  EXPECT_EQ(model.pieces[2].shape.margin(), 0.05);
}

TEST(RobotModel, PaddingOfAnUnknownLinkThrowsWithTheNearestName) {
  ModelOptions options;
  options.link_padding["elbov"] = 0.05;
  const std::string said = errorOfLoading(link("elbow", kUnitBox), options);
  EXPECT_EQ(said, "link_padding: no link \"elbov\" (did you mean \"elbow\"?)");
}

TEST(RobotModel, PaddingThatLeavesNothingThrowsNamingTheLink) {
  ModelOptions options;
  options.link_padding["thin"] = -0.2;
  expectSays(errorOfLoading(link("thin", collision(kBall)), options), "thin");
}

// --- bodies

TEST(RobotModel, FixedJointsFoldIntoOneBody) {
  const RobotModel model =
      load(link("base") + link("plate", kUnitBox) + link("arm", kUnitBox) + link("tool", kUnitBox) +
           joint("mount", "fixed", "base", "plate", "<origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/>") +
           joint("turn", "continuous", "plate", "arm", "<origin xyz='2 0 0'/><axis xyz='0 0 1'/>") +
           joint("flange", "fixed", "arm", "tool", "<origin xyz='3 0 0'/>"));
  ASSERT_EQ(model.bodies.size(), 2U);
  EXPECT_EQ(model.links[model.bodies[0].link].name, "base");
  EXPECT_EQ(model.links[model.bodies[1].link].name, "arm");
  EXPECT_EQ(model.bodies[0].joint, -1);
  EXPECT_EQ(model.bodies[0].parent, -1);
  EXPECT_EQ(model.joints[model.bodies[1].joint].name, "turn");
  EXPECT_EQ(model.bodies[1].parent, 0);
  const Link& plate = model.links[model.findLink("plate")];
  const Link& tool = model.links[model.findLink("tool")];
  EXPECT_EQ(plate.body, 0);
  EXPECT_EQ(tool.body, 1);
  expectNear(plate.body_T_link, at(0, 0, 1) * Isometry3d(Eigen::AngleAxisd(kPi / 2, Vector3d::UnitZ())));
  expectNear(tool.body_T_link, at(3, 0, 0));
  EXPECT_EQ(model.fixed_joints.size(), 2U);
  EXPECT_EQ(model.findLink("nobody"), -1);
}

TEST(RobotModel, BodiesComeParentsFirst) {
  // Names in the opposite order of the tree.
  std::string urdf = link("z", kUnitBox);
  const std::string names = "zyxwv";
  for (std::size_t i = 1; i < names.size(); ++i) {
    urdf += link(names.substr(i, 1), kUnitBox);
    urdf += joint("j" + names.substr(i, 1), "continuous", names.substr(i - 1, 1), names.substr(i, 1));
  }
  const RobotModel model = load(urdf);
  ASSERT_EQ(model.bodies.size(), 5U);
  for (int i = 0; i < 5; ++i) EXPECT_LT(model.bodies[i].parent, i);
}

// --- joints

std::string twoLinks(const std::string& type, const std::string& body) {
  return link("a", kUnitBox) + link("b", kUnitBox) + joint("elbow", type, "a", "b", body);
}

TEST(RobotModel, JointsHaveTypeAxisAndLimits) {
  const Joint revolute = load(twoLinks("revolute",
                                       "<axis xyz='0 3 4'/><limit lower='-1' upper='2' effort='1' "
                                       "velocity='5'/>"))
                             .joints.at(0);
  EXPECT_EQ(revolute.type, Joint::Type::Revolute);
  EXPECT_TRUE(revolute.axis.isApprox(Vector3d(0, 0.6, 0.8), 1e-15));
  EXPECT_EQ(revolute.lower, -1.0);
  EXPECT_EQ(revolute.upper, 2.0);
  EXPECT_EQ(revolute.max_velocity, 5.0);

  const Joint continuous = load(twoLinks("continuous", "")).joints.at(0);
  EXPECT_EQ(continuous.type, Joint::Type::Continuous);
  EXPECT_EQ(continuous.axis, Vector3d::UnitX());  // the default of a URDF
  EXPECT_EQ(continuous.lower, -kInfinity);
  EXPECT_EQ(continuous.upper, kInfinity);
  EXPECT_EQ(continuous.max_velocity, kInfinity);

  EXPECT_EQ(load(twoLinks("floating", "")).joints.at(0).type, Joint::Type::Floating);
  EXPECT_EQ(load(twoLinks("planar", "<axis xyz='0 0 2'/>")).joints.at(0).axis, Vector3d::UnitZ());
}

TEST(RobotModel, VelocityLimitOfZeroMeansUnstated) {
  const RobotModel model = load(twoLinks("continuous", "<limit effort='0' velocity='0'/>"));
  EXPECT_EQ(model.joints.at(0).max_velocity, kInfinity);
}

TEST(RobotModel, LimitsInTheWrongOrderAreNoneAndAWarning) {
  const RobotModel model = load(twoLinks("prismatic", "<limit lower='1' upper='-1' effort='0' velocity='0'/>"));
  EXPECT_EQ(model.joints.at(0).lower, -kInfinity);
  expectWarns(model, "\"elbow\"");
}

TEST(RobotModel, RobotWithoutCollisionGeometryLoadsWithAWarning) {
  expectWarns(load(link("a") + link("b") + joint("j", "fixed", "a", "b")), "collision geometry");
}

// --- motion

TEST(JointMotion, TurnsAboutOrSlidesAlongTheAxis) {
  Joint joint = load(twoLinks("continuous", "<axis xyz='0 0 1'/>")).joints.at(0);
  expectNear(jointMotion(joint, kPi / 2), Isometry3d(Eigen::AngleAxisd(kPi / 2, Vector3d::UnitZ())));
  joint.type = Joint::Type::Prismatic;
  expectNear(jointMotion(joint, 0.3), at(0, 0, 0.3));
  joint.type = Joint::Type::Planar;
  expectNear(jointMotion(joint, 0.3), Isometry3d::Identity());
}

/// base -- (0, 0, 1) turn about z -- elbow -- fixed (1, 0, 0) -- forearm -- (0, 0, 0) slide along x -- tip
const std::string kArm = link("base", kUnitBox) + link("elbow", kUnitBox) + link("forearm", kUnitBox) +
                         link("tip", kUnitBox) +
                         joint("turn", "continuous", "base", "elbow", "<origin xyz='0 0 1'/><axis xyz='0 0 1'/>") +
                         joint("weld", "fixed", "elbow", "forearm", "<origin xyz='1 0 0'/>") +
                         joint("slide", "prismatic", "forearm", "tip",
                               "<axis xyz='1 0 0'/><limit lower='0' upper='1' effort='0' velocity='0'/>");

TEST(ForwardKinematics, FollowsFixedAndMovableJoints) {
  const RobotModel model = load(kArm);
  const BodyPoses poses = forwardKinematics(model, {{"turn", kPi / 2}, {"slide", 0.5}});
  ASSERT_EQ(poses.size(), 3U);
  expectNear(*poses[0], Isometry3d::Identity());
  expectNear(*poses[1], at(0, 0, 1) * Isometry3d(Eigen::AngleAxisd(kPi / 2, Vector3d::UnitZ())));
  EXPECT_TRUE(poses[2]->translation().isApprox(Vector3d(0, 1.5, 1), 1e-12));
}

TEST(ForwardKinematics, JointsThatAreNotNamedAreAtZero) {
  const BodyPoses poses = forwardKinematics(load(kArm), {{"turn", 0.0}});
  EXPECT_TRUE(poses[2]->translation().isApprox(Vector3d(1, 0, 1), 1e-12));
}

TEST(ForwardKinematics, UnknownAndFixedJointsThrow) {
  const RobotModel model = load(kArm);
  expectSays(errorOf([&] { forwardKinematics(model, {{"tvrn", 0.0}}); }), "\"turn\"");
  expectSays(errorOf([&] { forwardKinematics(model, {{"weld", 0.0}}); }), "\"weld\"");
}

TEST(ForwardKinematics, PositionsByJointAreThoseByName) {
  const RobotModel model = load(kArm);
  const BodyPoses by_joint = forwardKinematics(model, std::vector<double>{0.7, 0.5});
  const BodyPoses by_name = forwardKinematics(model, {{"turn", 0.7}, {"slide", 0.5}});
  for (std::size_t body = 0; body < by_name.size(); ++body) expectNear(*by_joint[body], *by_name[body]);
}

TEST(ForwardKinematics, NotOnePositionForEachJointThrows) {
  const RobotModel model = load(kArm);
  expectSays(errorOf([&] { forwardKinematics(model, std::vector<double>{0.0}); }), "2 movable joints");
}

std::string slider(const std::string& name, const std::string& child, const std::string& mimic) {
  return joint(name, "prismatic", "a", child,
               "<axis xyz='1 0 0'/><limit lower='0' upper='9' effort='0' velocity='0'/>" + mimic);
}
const std::string kFourLinks = link("a", kUnitBox) + link("b", kUnitBox) + link("c", kUnitBox) + link("d", kUnitBox);

TEST(ForwardKinematics, MimicJointsFollowInChains) {
  // x_d = 0.5 x_c + 1, x_c = -2 x_b + 3
  const RobotModel model =
      load(kFourLinks + slider("jd", "d", "<mimic joint='jc' multiplier='0.5' offset='1'/>") +
           slider("jc", "c", "<mimic joint='jb' multiplier='-2' offset='3'/>") + slider("jb", "b", ""));
  const BodyPoses poses = forwardKinematics(model, {{"jb", 0.25}, {"jd", 77.0}});
  EXPECT_NEAR(poses[model.links[model.findLink("c")].body]->translation().x(), 2.5, 1e-12);
  EXPECT_NEAR(poses[model.links[model.findLink("d")].body]->translation().x(), 2.25, 1e-12);
}

TEST(RobotModel, MimicInACircleThrows) {
  expectSays(errorOfLoading(kFourLinks + slider("jb", "b", "<mimic joint='jc'/>") +
                            slider("jc", "c", "<mimic joint='jb'/>") + slider("jd", "d", "<mimic joint='jb'/>")),
             "circle");
  expectSays(errorOfLoading(kFourLinks + slider("jb", "b", "<mimic joint='jb'/>") + slider("jc", "c", "") +
                            slider("jd", "d", "")),
             "\"jb\"");
}

TEST(RobotModel, MimicOfAnUnknownJointThrowsWithTheNearestName) {
  EXPECT_EQ(errorOfLoading(twoLinks("continuous", "<mimic joint='elbov'/>")),
            "URDF: joint \"elbow\" mimics the unknown joint \"elbov\" (did you mean \"elbow\"?); with "
            "allow_broken_mimics it is a joint of its own");
}

TEST(RobotModel, MimicsThatMakeNoSenseAreWarningsWhereAllowed) {
  ModelOptions options;
  options.allow_broken_mimics = true;
  const RobotModel model =
      load(kFourLinks + slider("jb", "b", "<mimic joint='nobody'/>") + slider("jc", "c", "<mimic joint='jc'/>") +
               slider("jd", "d", "<mimic joint='jb' multiplier='2'/>"),
           options);
  EXPECT_FALSE(model.joints.at(findNamed(model.joints, "jb")).mimic);
  EXPECT_FALSE(model.joints.at(findNamed(model.joints, "jc")).mimic);
  EXPECT_TRUE(model.joints.at(findNamed(model.joints, "jd")).mimic) << "the others stay";
  expectWarns(model, "joint \"jb\" mimics the unknown joint \"nobody\"; taken as a joint of its own");
  expectWarns(model, "joint \"jc\" mimics itself in a circle; taken as a joint of its own.");
  const BodyPoses poses = forwardKinematics(model, {{"jb", 0.25}, {"jc", 1.5}});
  EXPECT_NEAR(poses[model.links[model.findLink("b")].body]->translation().x(), 0.25, 1e-12);
  EXPECT_NEAR(poses[model.links[model.findLink("c")].body]->translation().x(), 1.5, 1e-12);
}

RobotModel revoluteWith(const std::vector<std::string>& limits) {
  std::string body = link("base", kUnitBox);
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    body += link("l" + number, kUnitBox) +
            joint("j" + number, "revolute", "base", "l" + number, "<limit " + limits[i] + " effort='1' velocity='1'/>");
  }
  return load(body);
}

TEST(RobotModel, LimitsThatLookLikeDegreesAreOneWarningForAllJoints) {
  const RobotModel model =
      revoluteWith({"lower='-180' upper='180'", "lower='0' upper='1.5'", "lower='-22.5' upper='90'"});
  EXPECT_EQ(model.warnings, std::vector<std::string>{
                                "Limits that look like degrees, but count as radians: joint \"j1\" from -180 to 180, "
                                "\"j3\" from -22.5 to 90. If they are in degrees, multiply them by pi / 180."});
}

TEST(RobotModel, LimitsOfSeveralTurnsAreNoWarning) {
  // Ten turns as a multiple of pi; about one and a half turns; a joint that turns for ever; limits as good as none.
  const RobotModel model =
      revoluteWith({"lower='-31.41592653589793' upper='31.41592653589793'", "lower='-10' upper='10'",
                    "lower='-1000' upper='1000'", "lower='-1e5' upper='1e5'"});
  EXPECT_TRUE(model.warnings.empty()) << model.warnings.front();
}

TEST(JointRanges, AreTheLimitsOrOneTurn) {
  const auto range = [](const RobotModel& model) {
    const JointRange only = jointRanges(model).at(0);
    return std::make_pair(only.lower, only.upper);
  };
  EXPECT_EQ(range(revoluteWith({"lower='-1' upper='2'"})), std::make_pair(-1.0, 2.0));
  const auto [lower, upper] = range(revoluteWith({"lower='-5' upper='7'"}));
  EXPECT_NEAR(lower, 1.0 - kPi, 1e-15) << "about the middle";
  EXPECT_NEAR(upper, 1.0 + kPi, 1e-15);
  const std::string with_follower = "<limit lower='-5' upper='7' effort='1' velocity='1'/>";
  const RobotModel followed = load(kFourLinks + joint("jb", "revolute", "a", "b", with_follower) +
                                   slider("jc", "c", "<mimic joint='jb'/>") + joint("jd", "fixed", "a", "d"));
  EXPECT_EQ(range(followed), std::make_pair(-5.0, 7.0));
  EXPECT_EQ(range(load(twoLinks("continuous", ""))), std::make_pair(-kPi, kPi));
}

// Regression: each of these refused the whole robot.
TEST(RobotModel, ABadMimicOfAJointThatMovesNoGeometryIsAWarning) {
  const auto lamp = [](const std::string& mimic) {
    return link("a", kUnitBox) + link("b") + link("bulb") + joint("cable", "continuous", "a", "b", mimic) +
           joint("screw", "fixed", "b", "bulb");
  };
  for (const std::string mimic : {"<mimic joint='cabel'/>", "<mimic joint='cable'/>"}) {
    const RobotModel model = load(lamp(mimic));
    EXPECT_FALSE(model.joints.at(0).mimic) << mimic;
    expectWarns(model, "joint \"cable\" mimics ");
    expectWarns(model, "moves no geometry; taken as a joint of its own");
  }
  const std::string with_geometry = link("a", kUnitBox) + link("b") + link("bulb", kUnitBox) +
                                    joint("cable", "continuous", "a", "b", "<mimic joint='cable'/>") +
                                    joint("screw", "fixed", "b", "bulb");
  expectSays(errorOfLoading(with_geometry), "joint \"cable\" mimics itself in a circle");
}

TEST(RobotModel, ACircleOfMimicsWithGeometryThrowsAlsoIfPartOfItMovesNone) {
  const std::string circle = link("a", kUnitBox) + link("b") + link("c", kUnitBox) +
                             slider("jb", "b", "<mimic joint='jc'/>") + slider("jc", "c", "<mimic joint='jb'/>");
  expectSays(errorOfLoading(circle), "joint \"jc\" mimics itself in a circle");
}

// The same rule as for a joint that does not exist: neither has a position that could be followed.
TEST(RobotModel, MimicOfAJointWithoutOnePositionThrowsUnlessAllowed) {
  const auto robot = [](const std::string& leader, const std::string& follower) {
    return link("a", kUnitBox) + link("b", kUnitBox) + link("c", kUnitBox) + joint("lead", leader, "a", "b") +
           joint("follow", follower, "a", "c", "<mimic joint='lead'/>");
  };
  const std::string fault =
      "joint \"follow\" mimics joint \"lead\", but one of the two is fixed, planar or floating, and so has no position";
  ModelOptions allowed;
  allowed.allow_broken_mimics = true;
  const std::pair<const char*, const char*> cases[] = {{"fixed", "continuous"},
                                                       {"planar", "continuous"},
                                                       {"floating", "continuous"},
                                                       {"continuous", "planar"},
                                                       {"continuous", "floating"}};
  for (const auto& [leader, follower] : cases) {
    EXPECT_EQ(errorOfLoading(robot(leader, follower)),
              "URDF: " + fault + "; with allow_broken_mimics it is a joint of its own");
    const RobotModel model = load(robot(leader, follower), allowed);
    EXPECT_FALSE(model.joints.at(findNamed(model.joints, "follow")).mimic);
    expectWarns(model, fault + "; taken as a joint of its own.");
  }
  EXPECT_TRUE(load(robot("continuous", "fixed")).warnings.empty()) << "a fixed joint needs no leader";
}

// --- broken URDFs

TEST(RobotModel, BrokenUrdfsThrow) {
  EXPECT_NE(errorOf([] { loadRobotModel("", noMesh); }), "");
  EXPECT_NE(errorOf([] { loadRobotModel("no XML", noMesh); }), "");
  EXPECT_NE(errorOf([] { loadRobotModel("<robot name='cut'><link", noMesh); }), "");
  expectSays(errorOf([] { loadRobotModel("<sdf/>", noMesh); }), "<robot>");
  expectSays(errorOfLoading(""), "no links");
}

// urdfdom answers most of these with a log line and a link without the shape.
TEST(RobotModel, BrokenGeometryThrowsNamingTheLink) {
  const std::string broken[] = {
      "<collision/>",
      "<collision><geometry/></collision>",
      collision("<sphere radius='nan'/>"),
      collision("<sphere radius='inf'/>"),
      collision("<sphere radius='1e999'/>"),
      collision("<sphere radius='0'/>"),
      collision("<sphere radius='-1'/>"),
      collision("<sphere radius='1,5'/>"),
      collision("<sphere/>"),
      collision("<box size='0 1 1'/>"),
      collision("<box size='1 nan 1'/>"),
      collision("<box size='1 1'/>"),
      collision("<cylinder radius='1' length='0'/>"),
      collision("<cylinder radius='1'/>"),
      collision("<capsule radius='1' length='1'/>"),
      collision("<box size='1 1 1'/><box size='1 1 1'/>"),
      collision("<box size='1 1 1'/>", "xyz='nan 0 0'"),
      collision("<box size='1 1 1'/>", "xyz='1 2'"),
      collision("<box size='1 1 1'/>", "rpy='0 0 inf'"),
      collision("<mesh/>"),
      collision("<mesh filename='a.stl' scale='2'/>"),
      "<collision><geometry><box size='1 1 1'/></geometry><geometry><box size='1 1 1'/></geometry></collision>",
      "<colision><geometry><box size='1 1 1'/></geometry></colision>",
  };
  for (const std::string& element : broken) {
    const std::string said = errorOfLoading(link("good", kUnitBox) + link("upper_arm", kUnitBox + element) +
                                            joint("j", "fixed", "good", "upper_arm"));
    EXPECT_NE(said.find("upper_arm"), std::string::npos) << element << " says \"" << said << "\"";
  }
}

TEST(RobotModel, XacroFilesAreRefusedWithTheCure) {
  const std::string said = errorOfLoading("\n<xacro:property name='l' value='1'/>" + link("a", kUnitBox));
  expectSays(said, "line 2");
  expectSays(said, "run xacro");
}

// Regression: all of these disappeared without a word.
TEST(RobotModel, DroppedElementsWithGeometryAreWarnings) {
  const RobotModel model =
      load(link("a", kUnitBox + "<geometry/>") + link("b", "<group>" + kUnitBox + "</group><gripper/>") +
           "<lnik name='c'>" + kUnitBox + "</lnik>" + joint("j", "fixed", "a", "b"));
  expectWarns(model, "link \"a\": the element <geometry>, line 1, is no part of a URDF");
  expectWarns(model, "link \"b\": the element <group>, line 1, ");
  expectWarns(model, "the element <lnik>, line 1, ");
  EXPECT_EQ(model.warnings.size(), 3U);
}

TEST(RobotModel, ElementsForOthersAreNoWarnings) {
  const RobotModel model =
      load(link("a", kUnitBox + "<visual><geometry><sphere radius='1'/></geometry></visual><inertial/>") +
           "<gazebo><collision/></gazebo><transmission><joint/></transmission><material/>");
  EXPECT_TRUE(model.warnings.empty()) << model.warnings.front();
}

TEST(RobotModel, ErrorTellsWhichCollision) {
  expectSays(errorOfLoading(link("a", kUnitBox + collision("<box size='0 1 1'/>"))), "<collision> 2");
}

TEST(RobotModel, BrokenTreesThrowNamingLinkOrJoint) {
  const std::string three = link("base") + link("upper") + link("lower");
  expectSays(errorOfLoading(link("base") + link("base")), "base");
  expectSays(errorOfLoading(three + joint("j", "fixed", "base", "upper")), "lower");  // two roots
  expectSays(errorOfLoading(three + joint("j", "fixed", "base", "upper") + joint("k", "fixed", "base", "lower") +
                            joint("l", "fixed", "upper", "lower")),
             "\"lower\"");  // two parents
  expectSays(errorOfLoading(three + joint("j", "fixed", "upper", "lower") + joint("k", "fixed", "lower", "upper")),
             "loop");
  expectSays(errorOfLoading(link("base") + joint("j", "fixed", "base", "nobody")), "nobody");
  expectSays(errorOfLoading(link("") + kUnitBox), "without a name");
}

TEST(RobotModel, BrokenJointsThrowNamingTheJoint) {
  const std::string broken[] = {
      twoLinks("revolute", ""),  // no limits
      twoLinks("rotary", ""),
      twoLinks("continuous", "<axis xyz='0 0 0'/>"),
      twoLinks("continuous", "<axis xyz='0 nan 0'/>"),
      twoLinks("continuous", "<mimic/>"),
      twoLinks("fixed", "<origin xyz='nan 0 0'/>"),
      twoLinks("planar", "") + joint("elbow", "fixed", "a", "b"),  // not unique
  };
  for (const std::string& urdf : broken) expectSays(errorOfLoading(urdf), "elbow");
}

TEST(RobotModel, LoadingIsQuietOnTheConsole) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  errorOfLoading(link("a", "<collision/>"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

// --- meshes

/// The unit box, and beside it the same moved by 2 along y.
const char* const kTwoBoxes =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "v 0 2 0\nv 1 2 0\nv 1 3 0\nv 0 3 0\nv 0 2 1\nv 1 2 1\nv 1 3 1\nv 0 3 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n"
    "f 9 12 11 10\nf 13 14 15 16\nf 9 10 14 13\nf 11 12 16 15\nf 10 11 15 14\nf 12 9 13 16\n";

class MeshRobot : public ::testing::Test {
 protected:
  MeshRobot() {
    files_.write("boxes/package.xml", "<package><name>boxes</name></package>");
    files_.write("boxes/two.obj", kTwoBoxes);
    files_.write("boxes/broken.stl", "no mesh");
  }
  RobotModel load(const std::string& body, const ModelOptions& options = {}) {
    return loadRobotModel(urdfOf(body), packageResolver({files_.path("")}), options);
  }
  static std::string mesh(const std::string& uri, const std::string& scale = "1 1 1") {
    return collision("<mesh filename='" + uri + "' scale='" + scale + "'/>");
  }
  TemporaryFiles files_;
};

TEST_F(MeshRobot, EachComponentOfAMeshIsAPiece) {
  const RobotModel model = load(link("a", mesh("package://boxes/two.obj")));
  ASSERT_EQ(model.collisions.at(0).pieces.size(), 2U);
  EXPECT_EQ(model.pieces[0].shape.hull().size(), 8);
  EXPECT_EQ(model.collisions[0].representation, Representation::Exact);
  EXPECT_EQ(model.collisions[0].description, "mesh package://boxes/two.obj");
}

// The two boxes are 1 x 3 x 1, in metres or in millimetres.
TEST_F(MeshRobot, AMeshInMillimetresIsAWarningThatNamesTheLink) {
  EXPECT_TRUE(load(link("a", mesh("package://boxes/two.obj"))).warnings.empty());
  const RobotModel model = load(link("a", mesh("package://boxes/two.obj", "1000 1000 1000")));
  expectWarns(model, "link \"a\", <collision> 1: mesh package://boxes/two.obj is 3316.62 m across");
  expectWarns(model, "scale=\"0.001 0.001 0.001\"");
}

/// Corners of an L, swept by one; open at both ends.
const char* const kOpenAngle =
    "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nv 0 0 1\nv 3 0 1\nv 3 1 1\nv 1 1 1\nv 1 3 1\nv 0 3 1\n"
    "f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";

TEST_F(MeshRobot, LinksMayHaveMeshTolerancesOfTheirOwn) {
  files_.write("boxes/angle.obj", kOpenAngle);
  const std::string angle = mesh("package://boxes/angle.obj");
  ModelOptions options;
  options.mesh_tolerance = 2.0;
  options.link_mesh_tolerance = {{"b", 0.0}};
  const RobotModel model = load(link("a", angle) + link("b", angle) + joint("j", "fixed", "a", "b"), options);
  EXPECT_EQ(model.collisions.at(0).representation, Representation::ConvexHull);
  EXPECT_EQ(model.collisions.at(1).representation, Representation::Triangles);
  EXPECT_EQ(model.collisions.at(1).pieces.size(), 12U);
}

TEST_F(MeshRobot, MeshToleranceOfAnUnknownLinkThrowsWithTheNearestName) {
  ModelOptions options;
  options.link_mesh_tolerance = {{"wrst", 0.01}};
  const std::string said = errorOf([&] { load(link("wrist", mesh("package://boxes/two.obj")), options); });
  EXPECT_NE(said.find("link_mesh_tolerance"), std::string::npos) << said;
  EXPECT_NE(said.find("\"wrist\""), std::string::npos) << said;
}

TEST_F(MeshRobot, ProgressNamesTheLinkThatTakesTime) {
  files_.write("boxes/angle.obj", kOpenAngle);
  std::vector<std::string> told;
  ModelOptions options;
  options.progress = [&](const std::string& what) { told.push_back(what); };
  load(link("wrist", mesh("package://boxes/two.obj") + mesh("package://boxes/angle.obj")), options);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("\"wrist\""), std::string::npos) << told[0];
}

TEST_F(MeshRobot, CacheThatCannotBeWrittenIsOneWarning) {
  files_.write("boxes/angle.obj", kOpenAngle);
  ModelOptions options;
  options.mesh_cache = files_.write("occupied", "a file");
  const std::string angle = mesh("package://boxes/angle.obj");
  EXPECT_EQ(warningsThatSay("occupied", load(link("a", angle + angle), options)).size(), 1U);
}

TEST_F(MeshRobot, UrisOfAllKindsNameTheSameMesh) {
  const std::string path = files_.path("boxes/two.obj");
  for (const std::string& uri :
       {std::string("package://boxes/two.obj"), std::string("package:///boxes/two.obj"), "file://" + path, path}) {
    EXPECT_EQ(load(link("a", mesh(uri))).pieces.size(), 2U) << uri;
  }
}

TEST_F(MeshRobot, MirroredScaleMirrorsThePieces) {
  const RobotModel model = load(link("a", mesh("package://boxes/two.obj", "1 -1 1")));
  Eigen::AlignedBox3d bounds;
  for (const Piece& piece : model.pieces) {
    EXPECT_DOUBLE_EQ(piece.shape.hull().volume(), 1.0);
    for (const Vector3d& vertex : piece.shape.hull().vertices()) bounds.extend(vertex);
  }
  EXPECT_EQ(bounds.min(), Vector3d(0, -3, 0));
  EXPECT_EQ(bounds.max(), Vector3d(1, 0, 1));
}

TEST_F(MeshRobot, SameFileInTwoScalesIsTwoMeshes) {
  const RobotModel model = load(link("a", mesh("package://boxes/two.obj") + mesh("package://boxes/two.obj", "2 2 2")));
  ASSERT_EQ(model.pieces.size(), 4U);
  EXPECT_DOUBLE_EQ(model.pieces[0].shape.hull().volume(), 1.0);
  EXPECT_DOUBLE_EQ(model.pieces[2].shape.hull().volume(), 8.0);
}

TEST_F(MeshRobot, MissingOrBrokenMeshThrowsNamingLinkAndFile) {
  for (const std::string uri : {"package://boxes/absent.stl", "package://nobody/a.stl", "package://boxes/broken.stl"}) {
    const std::string said = errorOf([&] { load(link("upper_arm", mesh(uri))); });
    expectSays(said, "upper_arm");
    expectSays(said, uri.substr(uri.rfind('/')));
  }
}

TEST_F(MeshRobot, MeshOfScaleZeroThrowsNamingTheLink) {
  expectSays(errorOf([&] { load(link("upper_arm", mesh("package://boxes/two.obj", "1 0 1"))); }), "upper_arm");
}

/// An open tent of 2 * n triangles that is no hull and no two hulls: a strip that zigzags along x.
std::string zigzag(int n) {
  std::ostringstream text;
  for (int i = 0; i <= n; ++i) {
    for (const int y : {0, 1}) text << "v " << 0.1 * i << " " << y << " " << 0.1 * (i % 2) << "\n";
  }
  for (int i = 0; i < n; ++i) {
    text << "f " << 2 * i + 1 << " " << 2 * i + 2 << " " << 2 * i + 3 << "\n";
    text << "f " << 2 * i + 2 << " " << 2 * i + 4 << " " << 2 * i + 3 << "\n";
  }
  return text.str();
}

/// Links a0, a1, ... of such meshes, each with one more tooth.
std::string zigzagLinks(TemporaryFiles& files, int count) {
  std::string body;
  for (int i = 0; i < count; ++i) {
    const std::string file = "boxes/zigzag" + std::to_string(i) + ".obj", name = "a" + std::to_string(i);
    files.write(file, zigzag(4 + i));
    body += link(name, collision("<mesh filename='package://" + file + "'/>"));
    if (i > 0) body += joint("j" + std::to_string(i), "fixed", "a0", name);
  }
  return body;
}

TEST_F(MeshRobot, NumberOfThreadsChangesNothing) {
  const std::string body = zigzagLinks(files_, 8);
  ModelOptions options;
  options.threads = 1;
  const RobotModel one = load(body, options);
  EXPECT_EQ(one.collisions.size(), 8U);
  EXPECT_GT(one.pieces.size(), 30U);
  for (const int threads : {0, 2, 3, 5, 100}) {
    options.threads = threads;
    const RobotModel model = load(body, options);
    ASSERT_EQ(model.pieces.size(), one.pieces.size());
    for (std::size_t i = 0; i < one.pieces.size(); ++i) {
      EXPECT_EQ(model.pieces[i].collision, one.pieces[i].collision);
      EXPECT_EQ(model.pieces[i].shape.hull().vertices(), one.pieces[i].shape.hull().vertices());
    }
    for (std::size_t i = 0; i < one.collisions.size(); ++i) {
      EXPECT_EQ(model.collisions[i].deviation, one.collisions[i].deviation);
      EXPECT_EQ(model.collisions[i].representation, one.collisions[i].representation);
    }
  }
}

TEST_F(MeshRobot, ProgressIsToldByTheCallingThreadOnceForEachMeshWithItsLinkAndFile) {
  const std::string body = zigzagLinks(files_, 8);
  ModelOptions options;
  options.threads = 4;
  std::vector<std::string> told;
  const std::thread::id caller = std::this_thread::get_id();
  options.progress = [&](const std::string& what) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    told.push_back(what);
  };
  load(body, options);
  ASSERT_EQ(told.size(), 8U);
  for (int i = 0; i < 8; ++i) {
    const auto isOf = [i](const std::string& what) {
      return what.find("\"a" + std::to_string(i) + "\"") != std::string::npos &&
             what.find("zigzag" + std::to_string(i)) != std::string::npos;
    };
    EXPECT_EQ(std::count_if(told.begin(), told.end(), isOf), 1) << i;
  }
}

TEST_F(MeshRobot, ProgressThatThrowsEndsTheLoading) {
  const std::string body = zigzagLinks(files_, 8);
  ModelOptions options;
  options.progress = [](const std::string&) { throw std::runtime_error("enough"); };
  EXPECT_THROW(load(body, options), std::runtime_error);
}

TEST_F(MeshRobot, AFlagEndsTheLoadingAlsoWhereMissingMeshesAreAllowed) {
  const std::string body = zigzagLinks(files_, 8);
  std::atomic<bool> stop{false};
  ModelOptions options;
  options.stop = &stop;
  options.allow_missing_meshes = true;
  options.progress = [&](const std::string&) { stop = true; };
  for (const int threads : {1, 3}) {
    options.threads = threads;
    stop = false;
    EXPECT_THROW(load(body, options), std::runtime_error);
    EXPECT_THROW(load(body, options), std::runtime_error) << "the flag is set from the start";
  }
  stop = false;
  options.progress = nullptr;
  EXPECT_EQ(load(body, options).collisions.size(), 8U);
}

TEST_F(MeshRobot, MeshThatTakesLongerThanItsTimeBudgetIsAWarningWithLinkFileAndReason) {
  files_.write("boxes/zigzag.obj", zigzag(200));
  ModelOptions options;
  options.mesh_time_budget = 0.01;
  const RobotModel model = load(link("tent", mesh("package://boxes/zigzag.obj", "0.5 0.5 0.5")), options);
  const std::vector<std::string> warnings = warningsThatSay("0.01 s", model);
  ASSERT_EQ(warnings.size(), 1U);
  for (const std::string what :
       {"link \"tent\"", "package://boxes/zigzag.obj", "400 triangles", "mesh_time_budget: 0.04"})
    expectSays(warnings[0], what);
}

TEST_F(MeshRobot, NumberOfThreadsChangesNoMeshWhoseTimeBudgetIsSpent) {
  const std::string body = zigzagLinks(files_, 6);
  ModelOptions options;
  options.mesh_time_budget = 1e-3;
  options.threads = 1;
  const RobotModel one = load(body, options);
  EXPECT_GT(warningsThatSay("mesh_time_budget: 0.004", one).size(), 0U);
  for (const int threads : {2, 3}) {
    options.threads = threads;
    const RobotModel model = load(body, options);
    EXPECT_EQ(model.warnings, one.warnings);
    ASSERT_EQ(model.pieces.size(), one.pieces.size());
    for (std::size_t i = 0; i < one.pieces.size(); ++i)
      EXPECT_EQ(model.pieces[i].shape.hull().vertices(), one.pieces[i].shape.hull().vertices());
  }
}

TEST_F(MeshRobot, FirstOfSeveralBrokenMeshesIsTheError) {
  for (const std::string file : {"b1", "b2", "b3"}) files_.write("boxes/" + file + ".stl", "no mesh");
  std::string body = link("a0", mesh("package://boxes/two.obj"));
  for (const std::string name : {"b1", "b2", "b3"})
    body += link(name, mesh("package://boxes/" + name + ".stl")) + joint("to_" + name, "fixed", "a0", name);
  ModelOptions options;
  for (const int threads : {1, 3}) {
    options.threads = threads;
    expectSays(errorOf([&] { load(body, options); }), "b1.stl");
  }
}

// Regression: a mesh that many links have was said to be open once for each of them.
TEST_F(MeshRobot, WhatIsSaidOfSeveralCollisionsIsOneWarningWithTheLinks) {
  files_.write("boxes/open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\n");
  const std::string open = mesh("package://boxes/open.obj");
  std::string body = link("a", open) + link("other", mesh("package://boxes/two.obj", "100 100 100"));
  body += joint("to_other", "fixed", "a", "other");
  for (const std::string name : {"b", "c", "d", "e", "f"})
    body += link(name, open + open) + joint("to_" + name, "fixed", "a", name);
  const RobotModel model = load(body);
  ASSERT_EQ(model.warnings.size(), 2U);
  expectWarns(model,
              "11 <collision> elements of the links \"a\", \"b\", \"c\", \"d\", \"e\" and 1 more: mesh "
              "package://boxes/open.obj: it is not a closed surface; ");
  expectWarns(model, "link \"other\", <collision> 1: mesh package://boxes/two.obj is 331.662 m across");
}

TEST_F(MeshRobot, MissingMeshIsAWarningWhereAllowed) {
  ModelOptions options;
  options.allow_missing_meshes = true;
  const RobotModel model = load(link("a", mesh("package://boxes/absent.stl") + kUnitBox), options);
  ASSERT_EQ(model.collisions.size(), 2U);
  EXPECT_TRUE(model.collisions[0].pieces.empty());
  EXPECT_EQ(model.collisions[1].number, 2);
  expectWarns(model, "absent.stl");
}

}  // namespace proximity_server::scene::robot_model_test
