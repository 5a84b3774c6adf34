#include "scene/object_files/utf8.h"

#include <stdexcept>

#include "proximity_server/scene/object_files/object_file.h"

namespace proximity_server::scene {
namespace {

/// How many bytes follow the first one of a character, and the bits of the first one that count; -1 if none begins so.
struct Lead {
  int following;
  std::uint32_t bits;
  std::uint32_t smallest;  ///< character that needs that many bytes
};
Lead leadOf(std::uint8_t byte) {
  if (byte < 0x80) return {0, byte, 0};
  if (byte >= 0xC0 && byte < 0xE0) return {1, byte & 0x1FU, 0x80};
  if (byte >= 0xE0 && byte < 0xF0) return {2, byte & 0x0FU, 0x800};
  if (byte >= 0xF0 && byte < 0xF8) return {3, byte & 0x07U, 0x10000};
  return {-1, 0, 0};
}

bool isCharacter(std::uint32_t code) { return code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF); }

}  // namespace

std::vector<std::uint32_t> codePointsOf(const std::string& text) {
  std::vector<std::uint32_t> codes;
  for (std::size_t i = 0; i < text.size();) {
    const Lead lead = leadOf(static_cast<std::uint8_t>(text[i++]));
    std::uint32_t code = lead.bits;
    int left = lead.following;
    for (; left > 0 && i < text.size(); --left) {
      const auto byte = static_cast<std::uint8_t>(text[i]);
      if ((byte & 0xC0U) != 0x80U) break;
      code = code << 6 | (byte & 0x3FU);
      ++i;
    }
    if (left != 0 || code < lead.smallest || !isCharacter(code)) throw std::invalid_argument("it is no text in UTF-8");
    codes.push_back(code);
  }
  return codes;
}

void requireUtf8(const std::string& text) { codePointsOf(text); }

}  // namespace proximity_server::scene
