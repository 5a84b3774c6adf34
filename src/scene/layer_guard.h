// The build includes this file before every source of this layer. There is no ROS here; its names do not compile.
#pragma GCC poison ros tf2 tf2_ros
