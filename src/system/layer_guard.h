// The build includes this file before every source of this layer. The layer knows the standard library and POSIX only;
// the names of other libraries and of higher layers do not compile.
#pragma GCC poison Eigen ros tf2 tf2_ros urdf aiScene fcl narrowphase RobotModel
