// The file keeps the objects between two starts of the node.
#include "node/objects/object_keeper.h"

#include "node/faults/small_disk.h"
#include "node/object_messages.h"
#include "robots/urdf.h"
#include "scene/files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

namespace proximity_server::node::object_keeper_test {

const std::string kBase = robots::urdfOf(robots::link("base"));

ObjectChanges changesWith(const std::string& id) { return messageOf({addBall(id)}); }

class Keeper : public testing::Test {
 protected:
  scene::TemporaryFiles files_;
  const std::string path_ = files_.path("objects.yaml");
  std::shared_ptr<const Robot> robot_ = std::make_shared<const Robot>(kBase, "", Config());
  ObjectStore store_{robot_, 7, [](const Robot&, const std::string&) { return Eigen::Isometry3d::Identity(); }};

  std::size_t keptObjects() const { return scene::readObjectFile(path_).objects.size(); }
};

TEST_F(Keeper, WritesAFileAtOnceIfThereIsNone) {
  const ObjectKeeper keeper(path_, store_);
  EXPECT_EQ(keptObjects(), 0u);
}

TEST_F(Keeper, LeavesAFileAsItIsUntilSomethingChanges) {
  const std::string text = "# mine\nobjects: []\n";
  files_.write("objects.yaml", text);
  {
    ObjectKeeper keeper(path_, store_);
    keeper.keep();
  }
  EXPECT_EQ(scene::readFile(path_), text);
}

TEST_F(Keeper, WritesTheLastChangeBeforeItEnds) {
  {
    ObjectKeeper keeper(path_, store_);
    store_.apply(changesWith("a"));
    keeper.keep();
    store_.apply(changesWith("b"));
  }
  EXPECT_EQ(keptObjects(), 2u);
  const std::filesystem::directory_iterator files(files_.path(""));
  EXPECT_EQ(std::distance(files, std::filesystem::directory_iterator()), 1) << "a draft is left";
}

TEST_F(Keeper, FollowsASymbolicLink) {
  const std::string target = files_.write("target.yaml", "objects: []");
  std::filesystem::create_symlink(target, path_);
  {
    const ObjectKeeper keeper(path_, store_);
    store_.apply(changesWith("a"));
  }
  EXPECT_TRUE(std::filesystem::is_symlink(path_));
  EXPECT_EQ(scene::readObjectFile(target).objects.size(), 1u);
}

TEST_F(Keeper, RefusesAFolderThatIsNotThere) {
  const std::string error = scene::errorOf([&] { ObjectKeeper("/nowhere/objects.yaml", store_); });
  EXPECT_NE(error.find("objects_file cannot be written: /nowhere/objects.yaml"), std::string::npos) << error;
}

TEST_F(Keeper, RefusesAFolderInWhichNoFileCanBeMade) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  files_.write("objects.yaml", "objects: []");
  const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
  std::filesystem::permissions(folder, std::filesystem::perms::owner_write, std::filesystem::perm_options::remove);
  EXPECT_THROW(ObjectKeeper(path_, store_), std::invalid_argument);
  std::filesystem::permissions(folder, std::filesystem::perms::owner_write, std::filesystem::perm_options::add);
}

// Regression: the node did not start.
TEST_F(Keeper, OfAFullDiskIsAProblemUntilThereIsRoom) {
  const SmallDisk disk(files_.path("small"));
  if (!disk.isMounted()) GTEST_SKIP() << "a small disk can be mounted by root only";
  disk.fill();
  const std::string file = files_.path("small/objects.yaml");
  const ObjectKeeper keeper(file, store_);
  EXPECT_EQ(keeper.problem(), file + ": writing failed (No space left on device)");
  EXPECT_FALSE(std::filesystem::exists(file));
  store_.apply(changesWith("a"));
  ASSERT_TRUE(disk.grow());
  while (!keeper.problem().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(scene::readObjectFile(file).objects.size(), 1u);
}

TEST_F(Keeper, OfADiskThatBecomesFullIsAProblemUntilThereIsRoom) {
  const SmallDisk disk(files_.path("small"));
  if (!disk.isMounted()) GTEST_SKIP() << "a small disk can be mounted by root only";
  const std::string file = files_.path("small/objects.yaml");
  ObjectKeeper keeper(file, store_);
  EXPECT_EQ(keeper.problem(), "");
  disk.fill();
  store_.apply(changesWith("a"));
  keeper.keep();
  while (keeper.problem().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(scene::readObjectFile(file).objects.size(), 0u) << "the objects before";
  ASSERT_TRUE(disk.grow());
  while (!keeper.problem().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(scene::readObjectFile(file).objects.size(), 1u);
}

TEST_F(Keeper, WithoutAFileNothingIsKept) {
  ObjectKeeper keeper("", store_);
  store_.apply(changesWith("a"));
  keeper.keep();
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(Keeper, TheFileWinsOverTheParameter) {
  Config config;
  config.objects.objects.resize(3);
  EXPECT_EQ(objectsAtStart(config).objects.size(), 3u);
  config.objects_file = path_;
  EXPECT_EQ(objectsAtStart(config).objects.size(), 3u) << "the file is not there yet";
  files_.write("objects.yaml", "objects: []");
  EXPECT_EQ(objectsAtStart(config).objects.size(), 0u);
}

TEST_F(Keeper, RefusesADamagedFileWithItsPlaceAndLeavesIt) {
  const std::string text = "objects:\n- id: a\n  primitives: [{type: SPHE\n";
  Config config;
  config.objects_file = files_.write("objects.yaml", text);
  const std::string error = scene::errorOf([&] { objectsAtStart(config); });
  EXPECT_EQ(error.rfind(path_ + ", line 4: this is no YAML: ", 0), 0u) << error;
  EXPECT_EQ(scene::readFile(path_), text);
}

}  // namespace proximity_server::node::object_keeper_test
