#include "system/whole_file.h"

#include "sanitized.h"
#include "scene/files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

namespace proximity_server::system::whole_file_test {

using scene::errorOf;
using scene::TemporaryFiles;

std::string readTextFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t filesIn(const TemporaryFiles& files) {
  const std::filesystem::directory_iterator begin(files.path(""));
  return static_cast<std::size_t>(std::distance(begin, std::filesystem::directory_iterator()));
}

TEST(WholeFile, HasItsNameOnceItIsComplete) {
  const TemporaryFiles files;
  WholeFile file(files.path("a"));
  file.append("one ");
  file.append("two");
  EXPECT_FALSE(std::filesystem::exists(files.path("a")));
  file.complete();
  EXPECT_EQ(readTextFile(files.path("a")), "one two");
  EXPECT_EQ(filesIn(files), 1U);
}

TEST(WholeFile, LeavesWhatWasThereIfItIsNotCompleted) {
  const TemporaryFiles files;
  files.write("a", "old");
  { WholeFile(files.path("a")).append("new"); }
  EXPECT_EQ(readTextFile(files.path("a")), "old");
  EXPECT_EQ(filesIn(files), 1U);
}

// Regression: the second one emptied the temporary file of the first, where both have the same name of the process: it
// waited for ever here, and for the first one to end in containers that count their processes alike.
TEST(WholeFile, IsNotDisturbedByAnotherOneOfTheSameProcess) {
  const TemporaryFiles files;
  WholeFile first(files.path("a")), second(files.path("a"));
  first.append("first");
  second.append("second");
  first.complete();
  EXPECT_EQ(readTextFile(files.path("a")), "first");
  second.complete();
  EXPECT_EQ(readTextFile(files.path("a")), "second");
  EXPECT_EQ(filesIn(files), 1U);
}

TEST(WholeFile, ReplacesItsBeginAfterAnyNumberOfBytes) {
  const TemporaryFiles files;
  WholeFile file(files.path("a"));
  file.append("head");
  const std::string megabytes(3000000, 'x');
  for (int i = 0; i < 3; ++i) file.append(megabytes);
  file.replaceBegin("HEAD");
  EXPECT_EQ(file.size(), 9000004U);
  file.complete();
  EXPECT_EQ(readTextFile(files.path("a")), "HEAD" + megabytes + megabytes + megabytes);
}

TEST(WholeFile, NamesWhatCannotBeWritten) {
  const TemporaryFiles files;
  EXPECT_EQ(errorOf([&] { WholeFile file(files.path("no/such")); }),
            files.path("no/such") + ": cannot be written (No such file or directory)");
  EXPECT_EQ(errorOf([&] { WholeFile file(files.path(".")); }), files.path(".") + ": is a folder, not a file");
}

TEST(WholeFile, LeavesNothingBehindIfItCannotBeGivenItsName) {
  const TemporaryFiles files;
  EXPECT_EQ(errorOf([&] {
              WholeFile file(files.path("a"));
              std::filesystem::create_directory(files.path("a"));
              file.complete();
            }),
            files.path("a") + ": cannot be given its name (Is a directory)");
  EXPECT_EQ(filesIn(files), 1U);
}

// /dev/full refuses every byte as a full disk does.
TEST(WholeFile, SaysThatTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  EXPECT_EQ(errorOf([] {
              WholeFile file("/dev/full");
              file.append("bytes");
              file.complete();
            }),
            "/dev/full: writing failed (No space left on device)");
}

TEST(WholeFile, WritesThroughToAPipeButCannotReplaceItsBegin) {
  const TemporaryFiles files;
  EXPECT_EQ(errorOf([] {
              WholeFile file("/dev/null");
              file.append("bytes");
              file.complete();
            }),
            "");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(WholeFile, LeftOversOfKilledProcessesAreRemovedAndThoseOfRunningOnesStay) {
  if (kIsSanitized) GTEST_SKIP() << kNoForkBesideThreads;
  const TemporaryFiles files;
  WholeFile running(files.path("a"));
  running.append("running");
  const pid_t child = fork();
  if (child == 0) {
    const WholeFile* killed = new WholeFile(files.path("a"));
    kill(getpid(), SIGKILL);
    _exit(killed ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  files.write(".b.other.tmp", "of another name");
  EXPECT_EQ(filesIn(files), 3U);
  removeLeftOvers(files.path("a"));
  EXPECT_EQ(filesIn(files), 2U);
  running.complete();
  EXPECT_EQ(readTextFile(files.path("a")), "running");
}

TEST(WholeFile, TwoProcessesMayWriteTheSameOne) {
  const TemporaryFiles files;
  WholeFile first(files.path("a"));
  first.append("same");
  const pid_t child = kIsSanitized ? -1 : fork();
  if (child == 0) {
    {
      WholeFile second(files.path("a"));
      second.append("same");
      second.complete();
    }
    _exit(0);
  }
  if (child > 0) waitpid(child, nullptr, 0);
  first.complete();
  EXPECT_EQ(readTextFile(files.path("a")), "same");
  EXPECT_EQ(filesIn(files), 1U);
}

}  // namespace proximity_server::system::whole_file_test
