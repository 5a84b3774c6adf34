# The Debian packages that `./dev package` makes of a build, one for each component. It adds the dependencies, which are
# known when everything is linked, and the pages of the manual, which the tools tell themselves.
install(CODE "file(GLOB pages \"${PROJECT_BINARY_DIR}/packages/man/*.gz\")
  file(INSTALL \${pages} DESTINATION \"\${CMAKE_INSTALL_PREFIX}/share/man/man1\")" COMPONENT node)

file(STRINGS package.xml maintainer_line REGEX "<maintainer")
string(REGEX REPLACE ".*email=\"(.*)\">(.*)<.*" "\\2 <\\1>" CPACK_PACKAGE_CONTACT "${maintainer_line}")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_BINARY_DIR}/packages/dependencies.cmake)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL library development messages node python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

foreach(component MESSAGES NODE PYTHON)
  set(CPACK_DEBIAN_${component}_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/src/packages/prerm)
endforeach()

# proximity_package(<component> <name of the package> <section> <description>)
macro(proximity_package component name section description)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${description}")
endmacro()
proximity_package(library libproximity-server libs
  "Distances of robots with proven bounds: the libraries\n GJK, EPA and time of contact of convex shapes, and of the links of a robot.")
proximity_package(development libproximity-server-dev libdevel
  "Distances of robots with proven bounds: headers\n For find_package(proximity_server), with catkin and without.")
proximity_package(messages proximity-server-msgs science
  "How far a robot is from itself: messages of the ROS node\n For who listens to the node or asks it from another computer: C++, Python, and find_package(proximity_server).")
proximity_package(node proximity-server science
  "How far a robot is from itself: ROS node and tools\n Services and a topic for a robot and what stands around it, and tools for many states.")
proximity_package(python python3-proximity python
  "Distances of robots with proven bounds: Python module\n From numpy to numpy: distances in many states, levels, gradients, and edges in joint space.")
include(CPack)
