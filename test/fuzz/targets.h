#pragma once

#include <cstdint>
#include <string>

namespace proximity_server::fuzz {

// A stranger's bytes may be taken, with a result that keeps its promises, or be refused with std::invalid_argument.
// Anything else ends the program.

/// First byte: the format ('s'TL, 'o'BJ, else DAE); the rest: the file.
void tryMesh(const std::string& bytes);

/// A URDF and, behind a line "=== SRDF ===", an SRDF.
void tryRobot(const std::string& bytes);

/// A file of joint states: a .npy or .npz if it begins so, else CSV.
void tryStates(const std::string& bytes);

/// First byte: the format ('s'cene of MoveIt, else YAML); the rest: a file of objects.
void tryObjectFile(const std::string& bytes);

/// First byte: the format ('p'cd, p'l'y, 'b't or 'o't); the rest: a file of points, or of an octree.
void tryCloudFile(const std::string& bytes);

// The inputs of the node.

/// Two messages of changes of objects, one after the other, see RequestBytes.
void tryObjects(const std::string& bytes);

/// First byte: how many bytes behind it are a PointCloud2 without data, see RequestBytes; the rest: its data.
void tryCloud(const std::string& bytes);

/// First byte: the service ('m'inimum_distance, query_'p'airs, query_'c'onfiguration, query_'t'rajectory,
/// prove_'j'oint_box, else time_of_contact); the rest: its request, see RequestBytes.
void tryRequest(const std::string& bytes);

/// Parameters of the node, as XML-RPC.
void tryParameters(const std::string& bytes);

}  // namespace proximity_server::fuzz
