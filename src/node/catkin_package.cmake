# Declares the catkin package. The top-level CMakeLists.txt includes it, because catkin must be called in the folder of
# package.xml.
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(catkin REQUIRED COMPONENTS
  diagnostic_updater
  dynamic_reconfigure
  geometry_msgs
  message_generation
  roscpp
  rosgraph_msgs
  sensor_msgs
  shape_msgs
  std_msgs
  std_srvs
  tf2
  tf2_msgs
  trajectory_msgs
  visualization_msgs
)

add_message_files(FILES
  Boxes.msg
  Clearance.msg
  ConstraintRows.msg
  JointInterval.msg
  LinkInfo.msg
  Lookahead.msg
  MeshFile.msg
  ModelInfo.msg
  MotionMinimum.msg
  ObjectChange.msg
  ObjectChanges.msg
  ObjectInfo.msg
  ObjectList.msg
  PairInfo.msg
  PairProof.msg
  PairRule.msg
  Proximity.msg
  RayHit.msg
  Record.msg
  QueryStatus.msg
  Sensed.msg
  SensedSource.msg
  Separation.msg
  ShapeInfo.msg
  ShapeKind.msg
  ShapeRef.msg
  StateProximity.msg
)
install(FILES msg/migration.bmr DESTINATION share/${PROJECT_NAME}/msg)
add_service_files(FILES
  ApplyObjects.srv
  FirstContact.srv
  MinimumDistance.srv
  PenetrationDepth.srv
  ProveJointBox.srv
  QueryConfiguration.srv
  QueryPairs.srv
  QueryPoints.srv
  QueryRays.srv
  QueryTrajectory.srv
  SeparationAxis.srv
)
generate_messages(DEPENDENCIES geometry_msgs sensor_msgs shape_msgs std_msgs trajectory_msgs)
generate_dynamic_reconfigure_options(config/Proximity.cfg)

# For who has the messages alone, too: src/proximity_server-targets.cmake adds the libraries, and Eigen, where they are installed.
catkin_package(
  INCLUDE_DIRS include
  CATKIN_DEPENDS geometry_msgs message_runtime sensor_msgs shape_msgs std_msgs trajectory_msgs
  CFG_EXTRAS ${PROJECT_SOURCE_DIR}/src/${PROJECT_NAME}-targets.cmake
)
