#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace proximity_server::fuzz {

/// Tries every file of a folder of the corpus, and returns how many there were.
inline int tryAll(const std::string& folder, void (*target)(const std::string&)) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PROXIMITY_SOURCE_DIR "/test/fuzz/corpus/" + folder)) {
    SCOPED_TRACE(entry.path());
    std::ifstream stream(entry.path(), std::ios::binary);
    EXPECT_NO_THROW(target({std::istreambuf_iterator<char>(stream), {}}));
    ++files;
  }
  return files;
}

}  // namespace proximity_server::fuzz
