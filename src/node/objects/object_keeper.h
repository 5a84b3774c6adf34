#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "node/objects/object_store.h"
#include "node/robot/config.h"
#include "proximity_server/scene/object_files/object_file.h"

namespace proximity_server::node {

/// What stands there when the node starts: what Config::objects_file holds if this file exists, else Config::objects.
/// Failure: throws std::invalid_argument naming the file, the line and the reason. The file stays as it is.
scene::ObjectFile objectsAtStart(const Config& config);

/// Keeps the objects of a store in a file, for the next start of the node. A thread of its own writes them, so that nobody waits for a
/// disk; of several changes in short order only the last is written. The file is replaced as a whole: whenever the node or the machine stops, it holds
/// what was there before or after a change.
class ObjectKeeper {
 public:
  /// `file` is an absolute path; "": nothing is kept. The store must outlive this.
  /// Failure: throws std::invalid_argument if there is no such file and none can be written.
  ObjectKeeper(std::string file, const ObjectStore& store);
  /// Writes what is not written yet.
  ~ObjectKeeper();
  ObjectKeeper(const ObjectKeeper&) = delete;
  ObjectKeeper& operator=(const ObjectKeeper&) = delete;

  /// Has the objects written if they have changed. Returns at once.
  void keep();

 private:
  void run();
  void writeIfChanged();

  const std::string file_;
  const ObjectStore& store_;
  std::optional<std::uint64_t> written_;  ///< revision; only the thread uses it while it runs
  bool has_failed_ = false;               ///< the same
  std::mutex mutex_;
  std::condition_variable wake_;
  bool is_asked_ = false, is_over_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace proximity_server::node
