#include "tools/sweep/program_digest.h"

#include <link.h>

#include <string>
#include <vector>

#include "tools/command_line/content_hash.h"

namespace proximity_server::tools {
namespace {

int addOurLibrary(dl_phdr_info* object, std::size_t /*size*/, void* files) {
  const std::string path = object->dlpi_name;
  if (path.find("libproximity_") != std::string::npos) static_cast<std::vector<std::string>*>(files)->push_back(path);
  return 0;
}

}  // namespace

std::string programDigest() {
  std::vector<std::string> files{"/proc/self/exe"};
  dl_iterate_phdr(addOurLibrary, &files);
  ContentHash hash;
  for (const std::string& file : files) hash.add(contentHash(file));
  return hash.text();
}

}  // namespace proximity_server::tools
