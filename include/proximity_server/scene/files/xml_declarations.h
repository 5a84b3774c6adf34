#pragma once

#include <string>

namespace proximity_server::scene {

/// Blanks the declarations `<?...?>` of an XML text that are not at its very beginning, such as one behind the comment
/// with a licence. XML forbids that one, and tinyxml2 refuses them all; urdfdom's parser passes over them. Lines keep
/// their numbers.
std::string withoutLateDeclarations(std::string xml);

}  // namespace proximity_server::scene
