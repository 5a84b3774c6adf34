#pragma once

#include <sys/mount.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

namespace proximity_server::node {

/// A small disk in memory. Only root may have one.
class SmallDisk {
 public:
  explicit SmallDisk(std::string folder) : folder_(std::move(folder)) {
    std::filesystem::create_directory(folder_);
    is_mounted_ = geteuid() == 0 && mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=64k") == 0;
  }
  ~SmallDisk() {
    if (is_mounted_) umount(folder_.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool isMounted() const { return is_mounted_; }
  bool grow() const { return mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT, "size=16m") == 0; }

  /// Writes a file until there is no room.
  void fill() const {
    std::ofstream file(folder_ + "/full");
    while (file) file << std::string(1024, 'x') << std::flush;
  }

 private:
  const std::string folder_;
  bool is_mounted_ = false;
};

}  // namespace proximity_server::node
