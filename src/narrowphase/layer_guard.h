// The build includes this file before every source of this layer. The layer knows Eigen, the standard library and qhull
// only; the names of other libraries do not compile.
#pragma GCC poison ros tf2 tf2_ros urdf aiScene fcl RobotModel
