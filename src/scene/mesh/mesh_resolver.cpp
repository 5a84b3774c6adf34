#include "proximity_server/scene/mesh/mesh_resolver.h"

#include "proximity_server/scene/mesh/readable_file.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

namespace fs = std::filesystem;

const std::string kPackage = "package://";
const std::string kFile = "file://";

bool startsWith(const std::string& text, const std::string& prefix) {
  return text.compare(0, prefix.size(), prefix) == 0;
}

std::optional<int> hexDigit(char digit) {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  if (digit >= 'A' && digit <= 'F') return digit - 'A' + 10;
  return std::nullopt;
}

/// Decodes the percent-encoding. A percent sign that is not part of a code ("%", "%zz") stays.
std::string decoded(const std::string& uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto high = uri[i] == '%' && i + 2 < uri.size() ? hexDigit(uri[i + 1]) : std::nullopt;
    const auto low = high ? hexDigit(uri[i + 2]) : std::nullopt;
    text += low ? static_cast<char>(16 * *high + *low) : uri[i];
    if (low) i += 2;
  }
  if (text.find('\0') != std::string::npos) throw std::invalid_argument(uri + ": %00 is no part of a path");
  return text;
}

[[noreturn]] void refuseScheme(const std::string& uri) {
  throw std::invalid_argument(uri + ": only package://, file:// and plain paths are known");
}

bool isPlainPath(const std::string& uri) { return uri.find("://") == std::string::npos; }

std::string textOf(const std::vector<std::string>& roots) {
  std::string text;
  for (const std::string& root : roots) text += (text.empty() ? "" : ", ") + root;
  return text.empty() ? "none, as ROS_PACKAGE_PATH and the like are empty" : text;
}

/// The name in a package.xml; "" if it cannot be read.
std::string packageName(const fs::path& package_xml) {
  // 1 MiB is far more than any manifest has.
  std::error_code failed;
  if (!fs::is_regular_file(package_xml, failed) || fs::file_size(package_xml, failed) > (1U << 20)) return "";
  tinyxml2::XMLDocument document(true, tinyxml2::COLLAPSE_WHITESPACE);
  document.LoadFile(package_xml.c_str());
  const tinyxml2::XMLElement* name =
      tinyxml2::XMLHandle(document).FirstChildElement("package").FirstChildElement("name").ToElement();
  return name && name->GetText() ? name->GetText() : "";
}

/// Finds the packages below one root, as rospack does: it does not search below a package, a CATKIN_IGNORE or a hidden
/// folder. It searches breadth first and only as far as needed, because a root may be as large as /usr/share.
class PackageSearch {
 public:
  explicit PackageSearch(const fs::path& root) { enqueue(root, 0); }

  std::optional<fs::path> find(const std::string& name) {
    while (!found_.count(name) && !frontier_.empty()) visitNext();
    const auto hit = found_.find(name);
    return hit == found_.end() ? std::nullopt : std::optional<fs::path>(hit->second);
  }

 private:
  struct Folder {
    fs::path path;
    int depth;
  };
  // More than any workspace has. They end the search of a root that is not a workspace ("/").
  static constexpr int kMaxDepth = 16;
  static constexpr std::size_t kMaxFolders = 200000;

  void enqueue(const fs::path& folder, int depth) {
    std::error_code failed;
    const fs::path real = fs::canonical(folder, failed);
    if (failed || depth > kMaxDepth || seen_.size() >= kMaxFolders) return;
    if (seen_.insert(real).second) frontier_.push_back({folder, depth});
  }

  void visitNext() {
    const Folder folder = frontier_.front();
    frontier_.pop_front();
    std::error_code ignored;
    if (fs::exists(folder.path / "CATKIN_IGNORE", ignored)) return;
    if (const fs::path package_xml = folder.path / "package.xml"; fs::exists(package_xml, ignored)) {
      found_.emplace(packageName(package_xml), folder.path);
      return;
    }
    for (fs::directory_iterator entry(folder.path, fs::directory_options::skip_permission_denied, ignored), end;
         !ignored && entry != end; entry.increment(ignored)) {
      if (entry->path().filename().string()[0] != '.' && entry->is_directory(ignored)) {
        enqueue(entry->path(), folder.depth + 1);
      }
    }
  }

  std::deque<Folder> frontier_;
  std::set<fs::path> seen_;  // real paths, so that circular links end
  std::map<std::string, fs::path> found_;
};

/// The packages below all roots.
class Packages {
 public:
  explicit Packages(const std::vector<std::string>& roots) : roots_(roots), searches_(roots.begin(), roots.end()) {}

  /// The file of package://name/path or package:///name/path.
  fs::path file(const std::string& uri) {
    const std::string text = decoded(uri);
    const std::size_t name_begin = text.find_first_not_of('/', kPackage.size());
    const std::size_t name_end = text.find('/', name_begin);
    if (name_begin == std::string::npos || name_end == std::string::npos) {
      throw std::invalid_argument(uri + ": expected package://<package>/<path>");
    }
    const std::string name = text.substr(name_begin, name_end - name_begin);
    const fs::path within = fs::path(text.substr(name_end)).relative_path();
    if (*within.lexically_normal().begin() == "..") throw std::invalid_argument(uri + ": leaves the package " + name);
    for (PackageSearch& search : searches_) {
      if (const std::optional<fs::path> folder = search.find(name)) return *folder / within;
    }
    throw std::invalid_argument(uri + ": no package named " + name +
                                " below the folders that are searched: " + textOf(roots_));
  }

 private:
  std::vector<std::string> roots_;
  std::vector<PackageSearch> searches_;
};

}  // namespace

std::string absoluteUri(const std::string& uri, const std::string& folder) {
  if (startsWith(uri, kPackage) || startsWith(uri, kFile)) return uri;
  if (!isPlainPath(uri)) refuseScheme(uri);
  if (fs::path(uri).is_absolute()) return uri;
  if (folder.empty()) {
    throw std::invalid_argument("'" + uri + "' is a relative path, and there is no folder in which it begins; an " +
                                "absolute path, package:// or file:// is needed");
  }
  return fs::path(folder) / uri;
}

MeshResolver packageResolver(const std::vector<std::string>& roots, const std::string& base_dir) {
  const auto packages = std::make_shared<Packages>(roots);
  return [packages, base = fs::path(base_dir)](const std::string& uri) {
    fs::path path;
    if (startsWith(uri, kPackage)) {
      path = packages->file(uri);
    } else if (startsWith(uri, kFile)) {
      path = decoded(uri).substr(kFile.size());
      if (!path.is_absolute()) throw std::invalid_argument(uri + ": expected file:///<absolute path>");
    } else if (isPlainPath(uri)) {
      path = base / uri;
    } else {
      refuseScheme(uri);
    }
    const std::string name = uri == path ? uri : uri + ": " + path.string();
    if (const std::string why = whyUnreadable(path); !why.empty())
      throw std::invalid_argument(name + ": cannot be read (" + why + ")");
    if (std::error_code failed; !fs::is_regular_file(path, failed))
      throw std::invalid_argument(name + " is not a regular file");
    return path.string();
  };
}

MeshResolver withinRoots(MeshResolver resolve, const std::vector<std::string>& roots) {
  if (roots.empty()) return resolve;
  std::vector<fs::path> allowed;
  for (const std::string& root : roots) {
    std::error_code failed;
    allowed.push_back(fs::canonical(root, failed));
    if (failed) throw std::invalid_argument("allowed mesh root " + root + ": " + failed.message());
  }
  return [resolve = std::move(resolve), allowed](const std::string& uri) {
    const std::string path = resolve(uri);
    const fs::path real = fs::canonical(path);
    const bool is_allowed = std::any_of(allowed.begin(), allowed.end(), [&](const fs::path& root) {
      return std::mismatch(root.begin(), root.end(), real.begin(), real.end()).first == root.end();
    });
    if (!is_allowed) throw std::invalid_argument(uri + ": " + real.string() + " lies below no allowed mesh root");
    return real.string();
  };
}

std::vector<std::string> rosPackagePath() {
  std::vector<std::string> roots;
  const char* variable = std::getenv("ROS_PACKAGE_PATH");
  std::istringstream list(std::string(variable ? variable : "") + ":/usr/share");
  for (std::string root; std::getline(list, root, ':');) {
    if (!root.empty() && std::find(roots.begin(), roots.end(), root) == roots.end()) roots.push_back(root);
  }
  return roots;
}

}  // namespace proximity_server::scene
