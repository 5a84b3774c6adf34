// Included before every source of this layer by the build: there is no ROS here, so that its names do not compile.
#pragma GCC poison ros tf2 tf2_ros
