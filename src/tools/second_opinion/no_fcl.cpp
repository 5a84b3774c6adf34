#include <stdexcept>

#include "tools/second_opinion/other_library.h"

namespace proximity_server::tools {

bool hasFcl() { return false; }
std::unique_ptr<OtherLibrary> makeFcl() { throw std::logic_error("this build has no FCL"); }

}  // namespace proximity_server::tools
