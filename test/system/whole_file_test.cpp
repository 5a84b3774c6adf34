#include "system/whole_file.h"

#include "sanitized.h"
#include "scene/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
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

namespace fs = std::filesystem;

TEST(WholeFile, ReplacesWhatALinkLeadsToAndKeepsItsPermissions) {
  const TemporaryFiles files;
  fs::create_directory(files.path("folder"));
  files.write("folder/a", "old");
  ASSERT_EQ(chmod(files.path("folder/a").c_str(), 0600), 0);
  fs::create_symlink("folder/a", files.path("second"));
  fs::create_symlink("second", files.path("first"));
  replaceFile(files.path("first"), "new");
  EXPECT_TRUE(fs::is_symlink(files.path("first")));
  EXPECT_TRUE(fs::is_symlink(files.path("second")));
  EXPECT_EQ(readTextFile(files.path("folder/a")), "new");
  EXPECT_EQ(fs::status(files.path("folder/a")).permissions(), fs::perms{0600});
}

TEST(WholeFile, MakesTheFileThatALinkLeadsTo) {
  const TemporaryFiles files;
  fs::create_symlink("a", files.path("link"));
  replaceFile(files.path("link"), "new");
  EXPECT_TRUE(fs::is_symlink(files.path("link")));
  EXPECT_EQ(readTextFile(files.path("a")), "new");
}

TEST(WholeFile, RefusesLinksInACircle) {
  const TemporaryFiles files;
  fs::create_symlink("b", files.path("a"));
  fs::create_symlink("a", files.path("b"));
  EXPECT_EQ(errorOf([&] { WholeFile file(files.path("a")); }),
            files.path("a") + ": cannot be written (Too many levels of symbolic links)");
}

TEST(WholeFile, LeavesAFileThatMayNotBeWritten) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TemporaryFiles files;
  files.write("a", "old");
  ASSERT_EQ(chmod(files.path("a").c_str(), 0400), 0);
  EXPECT_EQ(errorOf([&] { replaceFile(files.path("a"), "new"); }),
            files.path("a") + ": cannot be written (Permission denied)");
  EXPECT_EQ(readTextFile(files.path("a")), "old");
}

// A file behind a descriptor has other bytes before, and perhaps others who write.
TEST(WholeFile, AppendsToADescriptor) {
  const TemporaryFiles files;
  std::FILE* const log = std::fopen(files.path("log").c_str(), "w");
  ASSERT_TRUE(log);
  std::fputs("before ", log);
  std::fflush(log);
  replaceFile("/dev/fd/" + std::to_string(fileno(log)), "new");
  std::fclose(log);
  EXPECT_EQ(readTextFile(files.path("log")), "before new");
  EXPECT_EQ(filesIn(files), 1U);
  EXPECT_EQ(errorOf([] { WholeFile file("/dev/fd/999"); }), "/dev/fd/999: cannot be written (Bad file descriptor)");
}

TEST(WholeFile, RequireWritableLeavesEverythingAsItIs) {
  const TemporaryFiles files;
  requireWritable(files.write("a", "old"));
  requireWritable(files.path("b"));
  EXPECT_EQ(readTextFile(files.path("a")), "old");
  EXPECT_EQ(filesIn(files), 1U);
  EXPECT_EQ(errorOf([&] { requireWritable(files.path("no/such")); }),
            files.path("no/such") + ": cannot be written (No such file or directory)");
  ASSERT_EQ(mkfifo(files.path("pipe").c_str(), 0600), 0);
  requireWritable(files.path("pipe"));  // opening it would wait for a reader
}

// --- inputs and outputs

template <typename Call>
std::string conflictOf(const Call& call) {
  try {
    call();
  } catch (const FileConflict& conflict) {
    return conflict.what();
  }
  return "";
}

TEST(FileRoles, RefuseWhatIsReadAndWrittenInEitherOrder) {
  const TemporaryFiles files;
  const std::string a = files.write("a", "bytes");
  fs::create_hard_link(a, files.path("b"));
  const std::string text =
      "--out " + files.path("b") + ": is the same file as the mesh " + a + ", which is read and would be lost";
  FileRoles roles, reverse;
  roles.addInput("the mesh", a);
  EXPECT_EQ(conflictOf([&] { roles.addOutput("--out", files.path("b")); }), text);
  reverse.addOutput("--out", files.path("b"));
  EXPECT_EQ(conflictOf([&] { reverse.addInput("the mesh", a); }), text);
}

TEST(FileRoles, RefuseTwoOutputsAlsoOfAFileThatDoesNotExist) {
  const TemporaryFiles files;
  FileRoles roles;
  fs::create_symlink("new", files.path("link"));
  roles.addOutput("--out", files.path("new"));
  EXPECT_EQ(conflictOf([&] { roles.addOutput("--summary", files.path("link")); }),
            "--summary " + files.path("link") + ": is the same file as --out " + files.path("new") +
                ", and both would be written");
  EXPECT_EQ(conflictOf([&] { roles.addOutput("--summary", files.path("other")); }), "");
}

TEST(FileRoles, AllowDevicesToBeBoth) {
  FileRoles roles;
  roles.addInput("--states", "/dev/null");
  EXPECT_EQ(conflictOf([&] { roles.addOutput("--out", "/dev/null"); }), "");
  EXPECT_EQ(conflictOf([&] { roles.addOutput("--summary", "/dev/null"); }), "");
}

TEST(FileRoles, OfTheProcessForbidToWriteAnInput) {
  const TemporaryFiles files;
  const std::string a = files.write("a", "old");
  FileRoles::ofProcess().addInput("--states", a);
  EXPECT_EQ(conflictOf([&] { replaceFile(a, "new"); }),
            a + ": is the same file as --states " + a + ", which is read and would be lost");
  EXPECT_EQ(readTextFile(a), "old");
  EXPECT_EQ(filesIn(files), 1U);
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
