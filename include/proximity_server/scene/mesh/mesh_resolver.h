#pragma once

#include <functional>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// Converts a mesh URI of a URDF (package://, file://, a plain path) to a path that can be opened. Throws
/// std::invalid_argument, naming the URI, if that fails.
using MeshResolver = std::function<std::string(const std::string& uri)>;

/// Returns the URI of a mesh with an absolute path: a relative plain path begins in `folder`, all others stay
/// unchanged. Throws std::invalid_argument, naming the URI, for a scheme that no resolver knows, and for a relative
/// path if `folder` is empty.
std::string absoluteUri(const std::string& uri, const std::string& folder);

/// The resolver for programs without ROS. file:// and plain paths are taken as they are; relative paths begin in
/// `base_dir`. package://name/path (two or three slashes) is searched for below `roots` like in ROS_PACKAGE_PATH: a
/// folder with a package.xml that names the package. No path leaves the package through "..". Any other scheme is
/// refused. The percent-encoding of the two schemes is decoded ("%20" is a blank); a plain path has none.
MeshResolver packageResolver(const std::vector<std::string>& roots, const std::string& base_dir = {});

/// Resolves the same files, but only those below one of `roots` after all links are followed; all files if there are no
/// roots.
/// Throws std::invalid_argument for a root that does not exist; the resolver throws it for a file outside of the roots.
MeshResolver withinRoots(MeshResolver resolve, const std::vector<std::string>& roots);

/// The folders of the environment variable ROS_PACKAGE_PATH, and then /usr/share: Debian installs the packages of ROS
/// there, and its rospack and roslaunch find them without the variable.
std::vector<std::string> rosPackagePath();

}  // namespace proximity_server::scene
