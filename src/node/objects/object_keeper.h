#pragma once

#include "node/objects/object_store.h"
#include "node/robot/config.h"
#include "proximity_server/scene/object_files/object_file.h"

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace proximity_server::node {

/// The objects at the start of the node: those of Config::objects_file if this file exists, otherwise Config::objects.
/// Failure: throws std::invalid_argument naming the file, the line and the reason. The file stays as it is.
scene::ObjectFile objectsAtStart(const Config& config);

/// Keeps the objects of a store in a file, for the next start of the node. A thread of its own writes the file, so that
/// nobody waits for a disk. If several changes follow each other quickly, only the result of the last one is written.
/// The file is replaced as a whole, so that it always holds the objects before or after a change, whenever the node or
/// the machine stops. If writing fails, as on a full disk, it is tried again every second.
class ObjectKeeper {
 public:
  /// `file` is an absolute path; if it is "", nothing is kept. The store must outlive this object.
  /// Failure: throws std::invalid_argument if it may not be replaced or made, however much room there is.
  ObjectKeeper(std::string file, const ObjectStore& store);
  /// Writes the last change if it is not written yet.
  ~ObjectKeeper();
  ObjectKeeper(const ObjectKeeper&) = delete;
  ObjectKeeper& operator=(const ObjectKeeper&) = delete;

  /// Lets the thread write the objects if they have changed. Returns at once.
  void keep();

  /// The reason why the latest objects are not kept for the next start; "" if they are, or will be at once.
  std::string problem() const;

 private:
  void run();
  void tryToWrite();
  void writeIfChanged();

  const std::string file_;
  const ObjectStore& store_;
  std::optional<std::uint64_t> written_;  ///< revision of the file; used by the thread only, while it runs
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool is_write_requested_ = false, is_stopping_ = false;  // guarded by mutex_, as problem_
  std::string problem_;                                    ///< why the last attempt to write has failed; "": it has not
  std::thread thread_;
};

}  // namespace proximity_server::node
