// Faults while a record is written: of the disk, of the process, and of the clock.
#include "node/faults/small_disk.h"
#include "node/record/recorded_sliders.h"
#include "node/replay/replay.h"
#include "sanitized.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

namespace proximity_server::node::record_faults_test {

namespace fs = std::filesystem;

class RecordsUnderFaults : public RecordedSliders {
 protected:
  /// Records what happened so far and two seconds more, and returns how that ended.
  Recorder::Outcome save() {
    EXPECT_TRUE(recorder_->beginSaving());
    return recorder_->await();
  }
  std::set<std::string> filesOf(const std::string& folder) const {
    std::set<std::string> names;
    for (const auto& file : fs::directory_iterator(folder)) names.insert(file.path().filename());
    return names;
  }
  std::uint64_t cyclesOf(const std::string& file) const {
    std::ostringstream rows;
    const ReplayResult result = replay({file, {}}, rows);
    EXPECT_TRUE(result.agrees());
    return result.cycles;
  }
};

TEST_F(RecordsUnderFaults, OfAFullDiskAreAProblemUntilThereIsRoom) {
  const std::string folder = files_.path("small");
  const SmallDisk disk(folder);
  if (!disk.isMounted()) GTEST_SKIP() << "a small disk can be mounted by root only";
  config_.record_directory = folder;
  config_.record_memory = 4.0;
  start();
  for (int i = 0; i < 500; ++i) cycleAt(0.5);
  const Recorder::Outcome refused = save();
  EXPECT_EQ(refused.file, "");
  EXPECT_NE(refused.problem.find("No space left on device"), std::string::npos) << refused.problem;
  EXPECT_TRUE(filesOf(folder).empty()) << *filesOf(folder).begin();

  ASSERT_TRUE(disk.grow());
  for (int i = 0; i < 500; ++i) cycleAt(0.5);
  const Recorder::Outcome written = stop();
  EXPECT_EQ(written.problem, "");
  EXPECT_EQ(written.lost, 0u);
  EXPECT_EQ(cyclesOf(written.file), 500u) << "all but those that the disk refused";
}

TEST_F(RecordsUnderFaults, OfAFolderThatIsGoneForAWhileLoseNothing) {
  const std::string folder = files_.path("usb"), away = files_.path("away");
  fs::create_directory(folder);
  config_.record_directory = folder;
  start();
  for (int i = 0; i < 50; ++i) cycleAt(0.5);
  fs::rename(folder, away);
  const Recorder::Outcome refused = save();
  EXPECT_NE(refused.problem.find("No such file or directory"), std::string::npos) << refused.problem;
  fs::rename(away, folder);
  for (int i = 0; i < 50; ++i) cycleAt(0.5);
  const Recorder::Outcome written = stop();
  EXPECT_EQ(written.problem, "");
  EXPECT_EQ(cyclesOf(written.file), 100u);
}

// The folder goes while the temporary file is written, which then has no place for its name.
TEST_F(RecordsUnderFaults, OfAFolderThatGoesMeanwhileAreAProblem) {
  const std::string folder = files_.path("usb");
  fs::create_directory(folder);
  config_.record_directory = folder;
  start();
  cycleAt(0.5);
  ASSERT_TRUE(recorder_->beginSaving());
  while (fs::is_empty(folder)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  fs::rename(folder, files_.path("away"));
  recorder_->stop();
  EXPECT_EQ(recorder_->outcome().file, "");
  EXPECT_NE(recorder_->outcome().problem.find(folder), std::string::npos) << recorder_->outcome().problem;
}

TEST_F(RecordsUnderFaults, OfAKilledProcessLeaveNoHalfOne) {
  if (kIsSanitized) GTEST_SKIP() << kNoForkBesideThreads;
  const pid_t child = fork();
  if (child == 0) {
    start();
    for (;;) {  // ends by SIGKILL only
      cycleAt(0.5);
      recorder_->beginSaving();
      usleep(100);
    }
  }
  const auto hasTemporaryFile = [&] {
    const std::set<std::string> names = files();
    return std::any_of(names.begin(), names.end(), [](const std::string& name) { return name[0] == '.'; });
  };
  while (!hasTemporaryFile()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_EQ(kill(child, SIGKILL), 0);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  ASSERT_EQ(files().size(), 1u) << "the temporary file alone";
  ASSERT_TRUE(hasTemporaryFile());

  start();
  cycleAt(0.5);
  const std::string file = fs::path(stop().file).filename();
  EXPECT_EQ(files(), std::set<std::string>{file}) << "the next record removes it";
}

/// Sets the clock of this process. It is that of the system again at the end.
class SetClock {
 public:
  void set(double seconds) const { ros::Time::setNow(ros::Time(seconds)); }
  ~SetClock() { ros::Time::init(); }
};

TEST_F(RecordsUnderFaults, OfAClockThatJumpsHaveAllCyclesInTheirOrder) {
  const SetClock clock;
  start();
  for (const double begin : {500.0, 100.0, 900.0, 899.99, 0.0}) {
    time_ = begin;
    for (int i = 0; i < 10; ++i) {
      clock.set(time_);
      cycleAt(0.5);
    }
  }
  EXPECT_EQ(cyclesOf(stop().file), 50u);
}

// Regression: the event was looked for by the times of the bag, which do not jump back. So it was the first cycle.
TEST_F(RecordsUnderFaults, OfAClockThatJumpsExplainTheirEvent) {
  const SetClock clock;
  start();
  time_ = 500.0;
  clock.set(time_);
  for (int i = 0; i < 5; ++i) cycleAt(0.5);
  time_ = 100.0;
  for (const double right : {0.5, 0.21, 0.5}) {
    clock.set(time_);
    cycleAt(right);
  }
  const std::string text = explainEvent({stop().file, {}});
  EXPECT_EQ(text.find("stop: STOP: middle is 10.0 mm from right"), 0u) << text;
}

}  // namespace proximity_server::node::record_faults_test
