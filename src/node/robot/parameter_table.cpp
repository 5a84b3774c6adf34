#include "node/robot/parameter_table.h"

#include <utility>

namespace proximity_server::node {

using scene::Parameter;

std::vector<Parameter> parameterTable(Config& config) {
  constexpr auto kLive = Parameter::Change::Live, kReload = Parameter::Change::Reload,
                 kStart = Parameter::Change::Start;
  MonitorSettings& monitor = config.monitor;
  scene::ParameterRows add;

  add.heading = "The robot.";
  add("robot_description", &config.robot_description, {}, "", kReload,
      "Name of the parameter with the URDF, searched upwards from the node's namespace.");
  add("semantic_description", &config.semantic_description, {}, "", kReload,
      "Name of the parameter with the SRDF, searched the same way; \"\": no SRDF, and then all pairs of links are "
      "checked except those that a joint joins directly. It is an error if a name other than the default does not "
      "exist.");
  add("reference_frame", &config.reference_frame, {}, "", kReload,
      "Frame of all answers; \"\": the root link of the robot, or of the first robot by name. The pose of a link of "
      "the robot follows from the robot's joints, the pose of any other frame from tf; while tf does not know that "
      "frame, answers are INVALID.");
  add("tf_prefix", &config.tf_prefix, {}, "", kReload,
      "The robot's frames in tf are named PREFIX/link, \"\": as the links; robot_state_publisher has the same "
      "parameter, and it is searched upwards, so that both find it in a common namespace. Requests and answers name "
      "links without the prefix; header.frame_id has the prefix.");
  add("robots", &config.robots_value, {}, "", kReload,
      "Several robots in this node, by name, instead of `robot_description`, `semantic_description` and "
      "`tf_prefix`: `{left: {description: /left/robot_description, tf_prefix: left, joint_states: "
      "/left/joint_states}}`; {}: one robot. See [several robots](#several-robots).");

  for (Parameter& parameter : scene::robotParameters(config, monitor)) add.rows.push_back(std::move(parameter));
  add("objects_file", &config.objects_file, {}, "", kStart,
      "Absolute path of a file that keeps the objects and their rules for the next start, see [objects](#objects); "
      "\"\": objects do not outlive the node. If the file is there, `objects` is not used; if it is damaged, or its "
      "folder is not there, the node stops.");
  add("tracked", &config.tracked_value, {}, "", kReload,
      "People and things whose points come by a topic, `[{topic: /people, type: PoseArray, radius: 0.3}]`; []: "
      "none. See [tracked people and things](#tracked-people-and-things).");
  add("tracked_warn_distance", &monitor.tracked_warn_distance, {0, 100}, "m", kLive,
      "The `warn_distance` of pairs with a tracked source, also if a link has a distance of its own.");
  add("tracked_stop_distance", &monitor.tracked_stop_distance, {0, 100}, "m", kLive,
      "The `stop_distance` of pairs with a tracked source. It must be at most `tracked_warn_distance`; for "
      "`~constraints` it must be below `influence_distance`.");
  add("sensed", &config.sensed_value, {}, "", kReload,
      "Depth cameras and maps, `[{topic: /camera/points, resolution: 0.02, self_padding: 0.02}]`, see [what cameras "
      "see](../config/SENSED.md). []: none.");
  add("sensed_warn_distance", &monitor.sensed_warn_distance, {0, 100}, "m", kLive,
      "The same as `warn_distance` of pairs with a sensed source, also if a link has a distance of its own.");
  add("sensed_stop_distance", &monitor.sensed_stop_distance, {0, 100}, "m", kLive,
      "The same as `stop_distance` of pairs with a sensed source. It must be above the self padding of each of them "
      "plus "
      "the diagonal of its voxels, and for `~constraints` below `influence_distance`.");
  add("sensed_debounce", &monitor.sensed_debounce, {0, 10}, "s", kLive,
      "Pairs with sensed sources make the level WARN or STOP only after it would have been so for this long.");

  add.heading = "Transforms.";
  add("max_tf_age", &config.max_tf_age, {1e-3, 1e6}, "s", kReload,
      "Largest age of the common time of all needed joints, and how far that may be ahead of the clock; beyond it "
      "there is no answer: level INVALID, code TF_STALE. It must exceed the longest period of the joint states.");
  add("max_tf_skew", &config.max_tf_skew, {0, 1e6}, "s", kReload,
      "If the latest transforms of the joints differ by more in time, the diagnostics warn. The poses of an answer "
      "are of one time in any case.");
  add("tf_timeout", &config.tf_timeout, {0, 10}, "s", kReload,
      "Longest wall time for which a service waits for transforms that are missing or later.");

  add.heading = "Requests.";
  add("max_batch", &config.max_batch, {1, 1e9}, "", kReload,
      "The most pairs that one `query_pairs` or `query_configuration` may list or return: for each state one in the "
      "modes MINIMUM and FIRST, k in K_CLOSEST, every pair in all others; also the most points of one "
      "`query_trajectory`. A larger request is refused with OVER_BUDGET.");
  add("max_request_time", &config.max_request_time, {1e-6, 3600}, "s", kReload,
      "Longest wall time of one request. Pairs that have no answer by then are UNKNOWN, and the status is "
      "OVER_BUDGET; a longer `time_budget` is refused.");
  add("motion_time_budget", &config.motion_time_budget, {1e-4, 3600}, "s", kReload,
      "Wall time of one `time_of_contact` or `query_trajectory` whose `time_budget` is 0, at most "
      "`max_request_time`. When it ends, the answer has the status OVER_BUDGET and the numbers that are proven so "
      "far.");

  add.heading =
      "Records: the last seconds before an event, as a bag that `clearance --replay` answers again; see "
      "[records](../src/node/record/README.md).";
  add("record_seconds", &config.record_seconds, {0, 3600}, "s", kStart,
      "How much is kept and written of the time before an event. 0: nothing is recorded.");
  add("record_directory", &config.record_directory, {}, "", kStart,
      "Absolute path of a folder, for records of the events of `record_on`; one that is not there stops the node. "
      "\"\": only the service `save_record` writes, into proximity_server in `ROS_HOME` (~/.ros).");
  add("record_on", &config.record_on, {}, "", kStart,
      "A change of the level to one of these is an event: `[stop, collision, invalid]`. `[]`: all three.");
  add("record_count", &config.record_count, {1, 100000}, "", kStart,
      "So many records are kept of a node; the oldest ones are removed.");
  add("record_memory", &config.record_memory, {0.1, 10000}, "MB", kStart,
      "The memory for `record_seconds`. If a cycle has many pairs and bodies, and the rate is high, it may hold "
      "less: a cycle of a robot with 30 links and 10 listed pairs takes about 8 kB.");

  add.heading = "The system.";
  add("realtime_priority", &config.realtime_priority, {0, 99}, "", kStart,
      "SCHED_FIFO priority of the threads of monitor and tf, and of the thread that receives transforms and sends "
      "levels (unless `__tcpros_server_port` is set); 0: no real-time priority; the node warns if the system "
      "refuses it (`ulimit -r`). It helps if the processors are busy, but a monitor that takes longer than its "
      "period occupies one processor completely.");

  add.heading = "The monitor.";
  add("rate", &monitor.rate, {0, 1000}, "Hz", kLive,
      "Rate of `~clearance` in ROS time; 0: a cycle on every new set of transforms. Changed objects start a cycle "
      "at once, with a rate one at most between two of its own.");
  add("threshold", &monitor.threshold, {0, 100}, "m", kLive,
      "Pairs at or below this distance are listed in `~clearance`. A smaller value is faster.");
  add("hysteresis", &monitor.hysteresis, {0, 1}, "m", kLive,
      "A level is left only when the distance exceeds its threshold by more than this; of a pair with a smaller "
      "stop distance of its own by less, in proportion.");
  add("max_reported_pairs", &monitor.max_reported_pairs, {0, 10000}, "", kLive,
      "The most pairs that `~clearance` lists, closest first. It also has the number of all within `threshold`.");
  add("markers", &monitor.markers, {}, "", kLive, "Publish `~markers` while somebody listens.");
  add("lookahead", &monitor.lookahead, {0, 60}, "s", kLive,
      "How far ahead `~clearance` searches for the first contact, at `stop_distance`, or of objects at "
      "`object_stop_distance`, if every joint keeps its velocity of joint_states until it stops at its limit; 0: "
      "off. The result is UNKNOWN if a velocity is missing or older than `max_tf_age`, and if the search is not "
      "complete after a quarter of the period (2.5 ms at rate 0).");
  add("trajectories", &config.trajectories, {}, "", kReload,
      "Topics from which joint_trajectory_controllers take their trajectories, `[/arm_controller/command]`, or "
      "goals of their actions, `/arm_controller/follow_joint_trajectory/goal`; []: none. `lookahead` then searches "
      "along the splines that the controllers drive, see [trajectories](UNCERTAINTY.md#trajectories).");
  add("tracking_error", &config.tracking_error, {0, 10}, "rad or m", kReload,
      "For `trajectories`: how far each joint may be off its spline, besides a common delay of up to 0.1 s that the "
      "monitor finds by itself: one number for all joints, or `{elbow: 0.02}`, where the others keep the default. "
      "`lookahead` proves all motions that are so near; for a joint that is farther off it takes velocities, and "
      "says so.");
  add("tracking_velocity_error", &config.tracking_velocity_error, {0, 100}, "rad/s or m/s", kReload,
      "For `trajectories`: how far the velocity of each joint in joint_states may be off the velocity of its "
      "spline, as `tracking_error`. Until positions and velocities have been so near for 0.1 s, `lookahead` takes "
      "the velocities, too: the earlier contact counts.");
  add("gradients", &monitor.gradients, {}, "", kLive,
      "true: each pair that `~clearance` lists has its gradient by the joints. The message then has their names and "
      "positions.");

  add.heading = "The age of the poses. With `pose_latency` each pair has a `guaranteed` distance, too.";
  add("pose_latency", &config.pose_latency_value, {}, "", kReload,
      "How far each joint may have moved from the stamp of the poses until the message is used: off: not at all; "
      "velocity: by its velocity of joint_states and `max_acceleration`, without one of the two as limit; limit: by "
      "its velocity limit of the URDF. If a joint that moves a checked pair has no limit either, the level is "
      "INVALID, and the status names it.");
  add("message_latency", &config.message_latency, {0, 60}, "s", kReload,
      "For `pose_latency`: from a cycle of the monitor until its message is used. The age of the poses is added by "
      "the node.");
  add("max_acceleration", &config.max_acceleration, {0, 1e6}, "rad/s² or m/s²", kReload,
      "For `pose_latency`: how hard the joints accelerate at most, one number for all joints, or one for each: "
      "`{elbow: 5.0}`.");
  add("base_speed", &config.base_speed, {}, "m/s, rad/s", kReload,
      "For `pose_latency`: how fast the root of a robot moves at most that tf may move relative to what is checked "
      "with it, `{translation: 1.0, angle: 0.5}` or the number of the translation; of several robots for all or by "
      "name. Without one it must stand still in /tf_static, else the level is INVALID.");
  add("object_speed", &config.object_speed, {}, "m/s, rad/s", kReload,
      "As `base_speed`, of objects that move with a tf frame that is no link's, for all or by id.");

  add.heading =
      "For controllers: `~constraints` and `~collision_velocity_scale`, each published while somebody listens. Both "
      "keep `stop_distance` and `object_stop_distance`.";
  add("influence_distance", &monitor.influence_distance, {0, 100}, "m", kLive,
      "Pairs nearer than this have a row in `~constraints`. It must be above `stop_distance` and "
      "`object_stop_distance`: otherwise `~constraints` says so in its status, and has no rows.");
  add("damping_gain", &monitor.damping_gain, {1e-3, 1000}, "m/s", kLive,
      "How fast a pair at `influence_distance` may come nearer; at its stop distance that is 0, and linear between "
      "the two. A controller with a delay goes below the stop distance if the gain is large, see "
      "[constraints](../msg/README.md#constraints).");
  add("max_constraints", &monitor.max_constraints, {1, 1000}, "", kLive,
      "The rows of `~constraints`: the most demanding pairs that need one. Each message has so many.");
  add("constraint_joints", &config.constraint_joints, {}, "", kReload,
      "The joints that the controller of `~constraints` moves, `[left_s0, left_s1]`; all others count as at rest "
      "there: their columns are 0, and pairs whose distance only they change have no row. `[]`: all.");
  add("stop_latency", &monitor.stop_latency, {0, 60}, "s", kLive,
      "For `~collision_velocity_scale` and `~separation`: until the robot begins to brake, after the cycle has its "
      "poses: the sum of the computation, the period of the controller, and all transport. The age of the poses is "
      "added by the node.");
  add("max_deceleration", &config.max_deceleration, {1e-3, 1e6}, "rad/s² or m/s²", kReload,
      "For `~collision_velocity_scale` and `~separation`: how hard the joints can brake, one number for all joints, "
      "or one for each: `{elbow: 5.0, slide: 2.0}`. While a joint that moves a checked pair has none, the scale is "
      "0.");
  return add.rows;
}

}  // namespace proximity_server::node
