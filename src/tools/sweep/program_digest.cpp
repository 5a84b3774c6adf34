#include "tools/sweep/program_digest.h"

#include <link.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "proximity_server/scene/model/kinematics.h"
#include "tools/command_line/content_hash.h"

namespace proximity_server::tools {
namespace {

int addOurLibrary(dl_phdr_info* object, std::size_t /*size*/, void* files) {
  const std::string path = object->dlpi_name;
  if (path.find("libproximity_") != std::string::npos) static_cast<std::vector<std::string>*>(files)->push_back(path);
  return 0;
}

/// What a turning joint makes of many angles. The C library has other code where the processor has no fused products, and
/// about one sine in 1500 then differs in its last bit; so may those of another version of the library.
void addSines(ContentHash& hash) {
  constexpr int kAngles = 1 << 15;
  scene::Joint joint{};
  joint.type = scene::Joint::Type::Revolute;
  joint.axis = Eigen::Vector3d::UnitZ();
  for (int i = -kAngles; i < kAngles; ++i) {
    const Eigen::Matrix3d rotation = scene::jointMotion(joint, 1e-4 * i).linear();
    hash.add(rotation.data(), sizeof(double) * 9);
  }
}

}  // namespace

std::string programDigest() {
  std::vector<std::string> files{"/proc/self/exe"};
  dl_iterate_phdr(addOurLibrary, &files);
  ContentHash hash;
  for (const std::string& file : files) hash.add(contentHash(file));
  addSines(hash);
  return hash.text();
}

}  // namespace proximity_server::tools
