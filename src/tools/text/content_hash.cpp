#include "tools/text/content_hash.h"

#include "proximity_server/scene/mesh/readable_file.h"

#include <xxhash.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <new>
#include <stdexcept>
#include <vector>

namespace proximity_server::tools {
namespace {

XXH64_state_t* newState() {
  XXH64_state_t* state = XXH64_createState();
  if (!state) throw std::bad_alloc();
  XXH64_reset(state, 0);
  return state;
}

}  // namespace

ContentHash::ContentHash() : state_(newState(), [](XXH64_state_t* state) { XXH64_freeState(state); }) {}
ContentHash::~ContentHash() = default;

ContentHash& ContentHash::add(const void* data, std::size_t size) {
  XXH64_update(state_.get(), data, size);
  return *this;
}

ContentHash& ContentHash::add(const std::string& text) {
  std::array<unsigned char, 8> size{};
  for (std::size_t i = 0; i < size.size(); ++i)
    size[i] = static_cast<unsigned char>(std::uint64_t{text.size()} >> 8 * i);
  return add(size.data(), size.size()).add(text.data(), text.size());
}

std::string ContentHash::text() const {
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(XXH64_digest(state_.get())));
  return digits.data();
}

std::string contentHash(const std::string& path) {
  scene::requireReadable(path);
  std::ifstream stream(path, std::ios::binary);
  ContentHash hash;
  std::vector<char> buffer(std::size_t{1} << 20);
  while (stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || stream.gcount() > 0)
    hash.add(buffer.data(), static_cast<std::size_t>(stream.gcount()));
  if (stream.bad()) throw std::invalid_argument(path + ": reading failed");
  return hash.text();
}

}  // namespace proximity_server::tools
