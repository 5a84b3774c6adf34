#include "tools/text/content_hash.h"

#include "scene/files.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::content_hash_test {

using namespace scene;

// Source: the known answers of XXH64 with seed 0.
constexpr char kOfNothing[] = "ef46db3751d8e999";
constexpr char kOfAbc[] = "44bc2cf5ad770999";

TEST(ContentHash, GivesTheKnownAnswers) {
  EXPECT_EQ(ContentHash().text(), kOfNothing);
  EXPECT_EQ(ContentHash().add("abc", 3).text(), kOfAbc);
  EXPECT_EQ(ContentHash().add("a", 1).add("bc", 2).text(), kOfAbc);
}

TEST(ContentHash, OfTextsKnowsWhereEachEnds) {
  const std::string a = "a", ab = "ab", bc = "bc", c = "c";
  EXPECT_NE(ContentHash().add(a).add(bc).text(), ContentHash().add(ab).add(c).text());
  EXPECT_NE(ContentHash().add(a).text(), ContentHash().add(a).add(std::string()).text());
}

// More than one portion.
TEST(ContentHash, OfAFileIsThatOfItsBytes) {
  const TemporaryFiles files;
  std::string bytes;
  for (int i = 0; i < 3000000; ++i) bytes += static_cast<char>(i % 251 * (i % 241));
  EXPECT_EQ(contentHash(files.write("large", bytes)), ContentHash().add(bytes.data(), bytes.size()).text());
  EXPECT_EQ(contentHash(files.write("abc", "abc")), kOfAbc);
  EXPECT_EQ(contentHash(files.write("empty", "")), kOfNothing);
}

TEST(ContentHash, NamesTheFileThatCannotBeRead) {
  const TemporaryFiles files;
  const std::string nowhere = files.path("nowhere"), folder = files.path("");
  EXPECT_EQ(errorOf([&] { contentHash(nowhere); }), nowhere + ": cannot be read (No such file or directory)");
  EXPECT_EQ(errorOf([&] { contentHash(folder); }), folder + ": cannot be read (Is a directory)");
}

}  // namespace proximity_server::tools::content_hash_test
