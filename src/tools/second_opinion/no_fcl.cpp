#include "tools/second_opinion/other_library.h"

namespace proximity_server::tools {

AskOther makeFcl() { return nullptr; }

}  // namespace proximity_server::tools
