# Two ways to keep the build short: precompiled headers, and sources that are compiled together.
#
# Headers that are compiled once: reading Eigen, the standard library and ROS took most of the time of nearly every source. They
# replace no #include: `./dev lint` compiles each source without them. Headers that are not here cost more than they
# bring: inline functions make the compiler instantiate their templates in each source.
#
#   system_headers                      the standard library, and then the guard of the layer
#   narrowphase_headers, scene_headers  Eigen and the standard library, and then the guard of the layer
#   proximity_headers                   the same without a guard: tools, python
#   ros_headers                         and ROS: node, demo
#   test_headers, ros_test_headers      and GTest: test/CMakeLists.txt
set(precompiled_std <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <condition_variable> <cstdint>
  <fstream> <functional> <iostream> <limits> <map> <memory> <mutex> <numeric> <optional> <random> <set> <sstream>
  <stdexcept> <string> <thread> <tuple> <utility> <variant> <vector>)
set(precompiled_eigen <Eigen/Geometry> ${precompiled_std})
set(precompiled_ros <diagnostic_msgs/DiagnosticArray.h> <dynamic_reconfigure/Reconfigure.h> <geometry_msgs/TransformStamped.h>
  <ros/callback_queue.h> <ros/ros.h> <ros/serialization.h> <sensor_msgs/JointState.h> <shape_msgs/SolidPrimitive.h>
  <std_srvs/Trigger.h> <tf2/buffer_core.h> <tf2_msgs/TFMessage.h> <trajectory_msgs/JointTrajectory.h>
  <visualization_msgs/MarkerArray.h>)

# proximity_add_headers(<name> <header>...): the precompiled headers of that name, for the options that all targets have.
function(proximity_add_headers name)
  set(source ${PROJECT_BINARY_DIR}/${name}.cpp)
  if(NOT EXISTS ${source})
    file(WRITE ${source} "")
  endif()
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${source})
  target_link_libraries(${name} PRIVATE Eigen3::Eigen)
  target_compile_options(${name} PRIVATE -fno-semantic-interposition -ffp-contract=off)
  target_compile_definitions(${name} PRIVATE EIGEN_MAX_STATIC_ALIGN_BYTES=16)
  target_precompile_headers(${name} PRIVATE ${ARGN})
endfunction()

# proximity_layer_options(<layer> <target>): as proximity_compile_options(), and the names of higher layers do not compile;
# test/CMakeLists.txt has the tests of this. The guard is in the precompiled headers, as nothing may stand before these.
function(proximity_layer_options layer target)
  set(precompiled_headers ${layer}_headers)
  proximity_compile_options(${target})
  if(CMAKE_DISABLE_PRECOMPILE_HEADERS)
    target_compile_options(${target} PRIVATE -include ${PROJECT_SOURCE_DIR}/src/${layer}/layer_guard.h)
  endif()
endfunction()

# proximity_compile_rooms(<target>): the sources of a folder are compiled together, as the templates of Eigen that they share take
# longer than the sources; so a room has one definition of a name. Errors name the source. `./dev lint` compiles each by itself, and
# so does a CMake that knows no groups of sources.
function(proximity_compile_rooms target)
  if(CMAKE_DISABLE_PRECOMPILE_HEADERS OR CMAKE_VERSION VERSION_LESS 3.18)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_filename_component(room ${source} DIRECTORY)
    if(NOT source MATCHES "[$<>]|^/")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "room${room}")
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)  # it takes the sources for headers
endfunction()

find_package(Eigen3 REQUIRED NO_MODULE)
proximity_add_headers(system_headers ${precompiled_std} ${PROJECT_SOURCE_DIR}/src/system/layer_guard.h)
foreach(layer narrowphase scene)
  proximity_add_headers(${layer}_headers ${precompiled_eigen} ${PROJECT_SOURCE_DIR}/src/${layer}/layer_guard.h)
endforeach()
proximity_add_headers(proximity_headers ${precompiled_eigen})
set(precompiled_headers proximity_headers)
if(catkin_FOUND)
  proximity_add_headers(ros_headers ${precompiled_eigen} ${precompiled_ros})
  target_include_directories(ros_headers SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
endif()
