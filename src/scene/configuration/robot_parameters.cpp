#include "proximity_server/scene/configuration/robot_config.h"

namespace proximity_server::scene {

std::vector<Parameter> robotParameters(RobotConfig& config, LevelDistances& levels) {
  constexpr auto kLive = Parameter::Change::Live, kReload = Parameter::Change::Reload,
                 kStart = Parameter::Change::Start;
  ParameterRows add;

  add.heading = "Geometry and pairs. The tools and the Python module read these parameters, too, up to the objects.";
  add("mesh_roots", &config.mesh_roots, {}, "", kReload,
      "Folders that are searched for `package://` before the folders of ROS_PACKAGE_PATH.");
  add("allowed_mesh_roots", &config.allowed_mesh_roots, {}, "", kReload,
      "Folders below which every mesh must lie, once symbolic links are followed, however the URDF names it; []: "
      "anywhere. In any case only package://, file:// and plain paths are read; another scheme (http://), or a `..` "
      "out of its package, is refused.");
  add("allow_missing_meshes", &config.model.allow_missing_meshes, {}, "", kReload,
      "false: a mesh that cannot be read stops the node. true: the node only warns, and that geometry is NOT checked.");
  add("allow_broken_mimics", &config.model.allow_broken_mimics, {}, "", kReload,
      "false: a mimic that makes no sense, as of a joint that does not exist or is fixed, stops the node. true: the "
      "node only warns, and the joint has a position of its own, from tf as all joints.");
  add("collision_from_visual", &config.model.collision_from_visual, {}, "", kReload,
      "Links without `<collision>` whose `<visual>` geometry counts in its place: `[head, torso]`, or `all`; an "
      "SRDF group is all links that move when its joints do, unless a link has its name. Other links that are seen, "
      "but not checked, are named in a warning.");
  add("mesh_tolerance", &config.model.mesh_tolerance, {0, 1}, "m", kReload,
      "How far the convex pieces of a mesh may lie from it; 0: its triangles stand for it, unless hulls are exact. "
      "Smaller means more pieces, so slower loading and slower answers: see [meshes](#meshes).");
  add("link_mesh_tolerance", &config.model.link_mesh_tolerance, {0, 1}, "m", kReload,
      "Replaces `mesh_tolerance` for single links: `{gripper: 0.001}`.");
  add("mesh_time_budget", &config.model.mesh_time_budget, {1e-3, 3600}, "s", kReload,
      "How long the decomposition of one mesh may take, roughly in seconds of one core. A mesh that needs more gets "
      "a larger tolerance, and a warning in `~model_info`: see [meshes](#meshes).");
  add("mesh_cache", &config.mesh_cache, {}, "", kReload,
      "Folder of the cache of decomposed meshes, for the next start; \"\": no cache. user: "
      "$XDG_CACHE_HOME/proximity_server, or ~/.cache/proximity_server.");
  add("default_padding", &config.model.default_padding, {0, 10}, "m", kReload,
      "Offset of every shape, exact: the answers are distances of the padded shapes.");
  add("link_padding", &config.model.link_padding, {0, 10}, "m", kReload,
      "Replaces `default_padding` for single links: `{wrist: 0.01}`.");
  add("pair_padding", &config.filter.pair_padding, {0, 10}, "m", kReload,
      "Subtracted from the distance of single pairs: `[{links: [wrist, torso], padding: 0.05}]`.");
  add("exclude_pairs", &config.filter.exclude_pairs, {}, "", kReload,
      "Pairs that are not checked, besides those that the SRDF disables: `[[wrist, torso], [hand, torso]]`.");
  add("only_pairs", &config.filter.only_pairs, {}, "", kReload,
      "If this list is not empty, only its pairs are checked, whatever the SRDF says.");
  add("group", &config.filter.group, {}, "", kReload,
      "Only pairs in which a link of this SRDF group moves are checked. \"\": no restriction.");
  add("joint_inequalities", &config.joint_inequalities, {}, "", kReload,
      "Limits that couple joints, as a cable or a differential does: `[\"2*j1 - j2 <= 1.7\"]`, or the absolute path "
      "of a file with this list, see [coupled limits](#coupled-limits). An unknown joint, and inequalities without "
      "a solution, stop the node.");
  add("tolerance", &config.tolerance, {1e-14, 0.1}, "m", kReload,
      "Accepted difference of the two certified bounds of a distance. A larger one is faster.");

  add.heading = "Levels.";
  add("warn_distance", &levels.warn_distance, {0, 100}, "m", kLive,
      "At or below it the level of `~clearance` is WARN. If two levels apply, the worse one counts.");
  add("stop_distance", &levels.stop_distance, {0, 100}, "m", kLive,
      "At or below it the level is STOP; on contact it is COLLISION. It must be at most `warn_distance`: otherwise "
      "the node does not start, and a live change is refused.");
  add("pair_warn_distance", &config.thresholds.warn.of_pairs, {0, 100}, "m", kReload,
      "Replaces `warn_distance` for single pairs, as the parts of a hand that are always near: `[{links: [wrist, "
      "flange], distance: 0.01}]`. See [thresholds of single pairs](#thresholds-of-single-pairs).");
  add("pair_stop_distance", &config.thresholds.stop.of_pairs, {0, 100}, "m", kReload,
      "Replaces `stop_distance` for single pairs. It must be at most the warn distance of the pair, and below "
      "`influence_distance`.");
  add("link_warn_distance", &config.thresholds.warn.of_links, {0, 100}, "m", kReload,
      "Replaces `warn_distance`, and `object_warn_distance`, for the pairs of single links: `{gripper: 0.01}`.");
  add("link_stop_distance", &config.thresholds.stop.of_links, {0, 100}, "m", kReload,
      "Replaces `stop_distance`, and `object_stop_distance`, for the pairs of single links.");
  add("group_warn_distance", &config.thresholds.warn.of_groups, {0, 100}, "m", kReload,
      "As `link_warn_distance`, for the links that move when the joints of an SRDF group do.");
  add("group_stop_distance", &config.thresholds.stop.of_groups, {0, 100}, "m", kReload,
      "As `link_stop_distance`, for the links that move when the joints of an SRDF group do.");
  add("object_warn_distance", &levels.object_warn_distance, {0, 100}, "m", kLive,
      "The `warn_distance` of pairs with an object.");
  add("object_stop_distance", &levels.object_stop_distance, {0, 100}, "m", kLive,
      "The `stop_distance` of pairs with an object. It must be at most `object_warn_distance`.");

  add.heading =
      "What is not known exactly. With one of these, each pair has a `guaranteed` distance, the levels are decided "
      "by it, and so are `~constraints` and `~collision_velocity_scale`; see "
      "[uncertainty](UNCERTAINTY.md#uncertainty).";
  add("joint_uncertainty", &config.uncertainty.joint, {}, "rad or m", kReload,
      "How far the position of each joint may be off to either side: one number for all joints, or `{elbow: "
      "0.002}`. In this and the next four, `\"*\"` names all that a map does not name.");
  add("joint_frame_uncertainty", &config.uncertainty.joint_frame, {}, "m, rad", kReload,
      "How far the place of each joint on its parent may be off: `{translation: 0.001, angle: 0.002}` or the number "
      "of the translation, for all joints or by name. A link that is 3 mm longer displaces all that is behind it.");
  add("base_uncertainty", &config.uncertainty.base, {}, "m, rad", kReload,
      "How far the root of the robot may be off its place relative to everything that it does not carry; of several "
      "robots for all or by name.");
  add("object_uncertainty", &config.uncertainty.object, {}, "m, rad", kReload,
      "How far objects may be off their place on what carries them, for all or by id.");
  add("link_uncertainty", &config.uncertainty.link, {}, "m", kReload,
      "How far the surface of links may be outside of their geometry: one number for all links, or `{hose: 0.01}`.");

  add.heading = "Objects: what the robot holds and what stands around it.";
  add("objects", &config.objects, {}, "", kStart,
      "The objects from the start, in the format of [objects](#objects), `[{id: table, pose: {position: {z: "
      "-0.5}}, primitives: [{type: BOX, dimensions: [1.0, 2.0, 0.05]}]}]`. In a launch file: `<rosparam "
      "param=\"objects\" command=\"load\" file=\"cell.yaml\"/>`.");
  add("check_free_objects", &config.free_objects, {}, "", kReload,
      "true: two objects that no link holds are checked too, if one of them moves with a frame. What a link holds "
      "is checked against all objects in any case.");
  return add.rows;
}

const std::vector<std::string>& parametersOfNode() {
  static const std::vector<std::string> kNames{
      "robot_description", "semantic_description",

      "tf_prefix", "robots", "max_tf_age", "max_tf_skew", "tf_timeout", "max_batch", "max_request_time",
      "motion_time_budget", "objects_file", "record_seconds", "record_directory", "record_on", "record_count",
      "record_memory", "realtime_priority", "rate", "threshold", "hysteresis", "max_reported_pairs", "markers",
      "lookahead", "trajectories", "tracking_error", "tracking_velocity_error", "gradients", "pose_latency",
      "message_latency", "max_acceleration", "base_speed", "object_speed", "influence_distance", "damping_gain",
      "max_constraints", "constraint_joints", "stop_latency", "max_deceleration", "diagnostic_period",
      "conditional_pairs",
      // tracked and sensed sources
      "tracked", "tracked_warn_distance", "tracked_stop_distance", "sensed", "sensed_warn_distance",
      "sensed_stop_distance", "sensed_debounce"};
  return kNames;
}

}  // namespace proximity_server::scene
