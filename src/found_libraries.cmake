# Libraries of which one of our systems has no CMake package, a wrong one, or another one: the package of assimp in
# Debian 11 names a folder that does not exist, and the targets of urdfdom have other names in Debian 13. As targets, so
# that who links our static libraries looks for them where he has them: src/proximity_server-targets.cmake.in.

# proximity_find_library(<name> <header> [<subfolder of /usr/include where the header may be>]): the target proximity_server::<name>;
# an error if library or header is not found.
function(proximity_find_library name header)
  string(TOUPPER ${name} prefix)
  find_library(${prefix}_LIBRARY NAMES ${name})
  find_path(${prefix}_INCLUDE_DIR NAMES ${header} PATH_SUFFIXES ${ARGN})
  if(NOT ${prefix}_LIBRARY OR NOT ${prefix}_INCLUDE_DIR)
    message(FATAL_ERROR "The library ${name} with its header ${header} was not found")
  endif()
  add_library(${PROJECT_NAME}::${name} UNKNOWN IMPORTED GLOBAL)
  set_target_properties(${PROJECT_NAME}::${name} PROPERTIES
    IMPORTED_LOCATION ${${prefix}_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${${prefix}_INCLUDE_DIR})
endfunction()
