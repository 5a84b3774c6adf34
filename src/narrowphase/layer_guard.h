// Included before every source of this layer by the build: here only Eigen, std and qhull are known, so that these
// names do not compile.
#pragma GCC poison ros tf2 tf2_ros urdf aiScene fcl RobotModel
