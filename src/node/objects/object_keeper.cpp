#include "node/objects/object_keeper.h"

#include "system/number_text.h"
#include "system/whole_file.h"

#include <ros/console.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace proximity_server::node {
namespace {

/// Time until a file that could not be written is tried again, because a full disk stays full for a while.
constexpr std::chrono::seconds kRetryPeriod{1};

bool exists(const std::string& path) {
  std::error_code ignored;
  return !path.empty() && std::filesystem::exists(path, ignored);
}

/// Throws std::invalid_argument if the file may not be replaced, or made, on a disk with room. It is not touched.
void requireAccess(const std::string& file) {
  std::error_code none;
  const std::filesystem::path target = std::filesystem::weakly_canonical(file, none);
  const bool may_make = access(target.parent_path().c_str(), W_OK | X_OK) == 0;
  if (!may_make || (exists(file) && access(file.c_str(), W_OK) != 0))
    throw std::invalid_argument("objects_file cannot be written: " + file + system::because(errno));
}

}  // namespace

scene::ObjectFile objectsAtStart(const Config& config) {
  const bool is_restored = exists(config.objects_file);
  scene::ObjectFile file = is_restored ? scene::readObjectFile(config.objects_file) : config.objects;
  for (const scene::ObjectEdit& object : file.objects)
    if (const TrackedSource* const source = config.findTracked(object.id))
      throw std::invalid_argument(object.source + ": id: it is a " + source->kind() + " source, see the parameter " +
                                  source->kind());
  for (const std::string& warning : file.warnings) ROS_WARN_STREAM(system::readable(warning));
  if (is_restored)
    ROS_INFO_STREAM(
        config.objects_file << ": " << file.objects.size() << " objects are restored"
                            << (config.objects.objects.empty() ? "" : "; the parameter objects is not used"));
  return file;
}

ObjectKeeper::ObjectKeeper(std::string file, const ObjectStore& store) : file_(std::move(file)), store_(store) {
  if (file_.empty()) return;
  requireAccess(file_);
  system::removeLeftOvers(file_);
  if (exists(file_))
    written_ = store_.revision();
  else
    tryToWrite();
  thread_ = std::thread([this] { run(); });
}

ObjectKeeper::~ObjectKeeper() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void ObjectKeeper::keep() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_write_requested_ = true;
  }
  wake_.notify_one();
}

std::string ObjectKeeper::problem() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return problem_;
}

void ObjectKeeper::run() {
  for (bool is_last = false; !is_last;) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      const auto must_wake = [this] { return is_write_requested_ || is_stopping_; };
      problem_.empty() ? wake_.wait(lock, must_wake) : static_cast<void>(wake_.wait_for(lock, kRetryPeriod, must_wake));
      is_write_requested_ = false;
      is_last = is_stopping_;
    }
    tryToWrite();
  }
}

/// Writes the objects if they have changed. A failure is logged if the last attempt was none.
void ObjectKeeper::tryToWrite() {
  std::string problem;
  try {
    writeIfChanged();
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!problem.empty() && problem_.empty())
    ROS_ERROR_STREAM("the objects are not kept for the next start: " << problem);
  problem_ = problem;
}

void ObjectKeeper::writeIfChanged() {
  if (written_ == store_.revision()) return;
  const ObjectStore::Snapshot now = store_.snapshot();
  system::replaceFile(file_, scene::yamlOf(now.file));
  written_ = now.revision;
}

}  // namespace proximity_server::node
