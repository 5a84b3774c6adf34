#include "node/objects/object_keeper.h"

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

/// Resolves symbolic links, so that the file that a link leads to is replaced, and not the link.
std::string resolvedPath(const std::string& path) {
  std::error_code failed;
  const std::filesystem::path target = std::filesystem::weakly_canonical(path, failed);
  return path.empty() || failed ? path : target.string();
}

bool exists(const std::string& path) {
  std::error_code ignored;
  return !path.empty() && std::filesystem::exists(path, ignored);
}

/// Throws std::system_error if no file can be made in the folder of `file`. The file itself is not touched.
void requireWritable(const std::string& file) {
  const std::string folder = std::filesystem::path(file).parent_path();
  if (access(folder.c_str(), W_OK | X_OK) != 0) throw std::system_error(errno, std::generic_category(), folder);
}

}  // namespace

scene::ObjectFile objectsAtStart(const Config& config) {
  if (!exists(config.objects_file)) return config.objects;
  scene::ObjectFile file = scene::readObjectFile(config.objects_file);
  ROS_INFO_STREAM(config.objects_file << ": " << file.objects.size() << " objects are restored"
                                      << (config.objects.objects.empty() ? "" : "; the parameter objects is not used"));
  return file;
}

ObjectKeeper::ObjectKeeper(std::string file, const ObjectStore& store) : file_(resolvedPath(file)), store_(store) {
  if (file_.empty()) return;
  system::removeLeftOvers(file_);
  try {
    exists(file_) ? requireWritable(file_) : writeIfChanged();
  } catch (const std::exception& error) {
    throw std::invalid_argument(std::string("objects_file cannot be written: ") + error.what());
  }
  written_ = store_.revision();
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

void ObjectKeeper::run() {
  for (bool is_last = false; !is_last;) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      const auto must_wake = [this] { return is_write_requested_ || is_stopping_; };
      has_failed_ ? static_cast<void>(wake_.wait_for(lock, kRetryPeriod, must_wake)) : wake_.wait(lock, must_wake);
      is_write_requested_ = false;
      is_last = is_stopping_;
    }
    try {
      writeIfChanged();
      has_failed_ = false;
    } catch (const std::exception& error) {
      if (!has_failed_) ROS_ERROR_STREAM("the objects are not kept for the next start: " << error.what());
      has_failed_ = true;
    }
  }
}

void ObjectKeeper::writeIfChanged() {
  if (written_ == store_.revision()) return;
  const ObjectStore::Snapshot now = store_.snapshot();
  system::replaceFile(file_, scene::yamlOf(now.file));
  written_ = now.revision;
}

}  // namespace proximity_server::node
