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

#include "proximity_server/scene/mesh/mesh_resolver.h"

namespace proximity_server::scene {
namespace {

namespace fs = std::filesystem;

const std::string kPackage = "package://";
const std::string kFile = "file://";

bool startsWith(const std::string& text, const std::string& prefix) {
  return text.compare(0, prefix.size(), prefix) == 0;
}

/// The name that a package.xml gives; "" where it cannot be read.
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

/// The packages below one root, found as rospack does: not below a package, a CATKIN_IGNORE or a hidden folder.
/// Breadth first and only as far as needed, since a root may be as large as /usr/share.
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
  // Far above any workspace; they end the crawl of a root that is none ("/").
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
  std::set<fs::path> seen_;  // real paths, so that circles of links end
  std::map<std::string, fs::path> found_;
};

/// package://name/path or package:///name/path.
fs::path packageFile(const std::string& uri, std::vector<PackageSearch>& searches) {
  const std::size_t name_begin = uri.find_first_not_of('/', kPackage.size());
  const std::size_t name_end = uri.find('/', name_begin);
  if (name_begin == std::string::npos || name_end == std::string::npos) {
    throw std::invalid_argument(uri + ": expected package://<package>/<path>");
  }
  const std::string name = uri.substr(name_begin, name_end - name_begin);
  const fs::path within = fs::path(uri.substr(name_end)).relative_path();
  if (*within.lexically_normal().begin() == "..") throw std::invalid_argument(uri + ": leaves the package " + name);
  for (PackageSearch& search : searches) {
    if (const std::optional<fs::path> folder = search.find(name)) return *folder / within;
  }
  throw std::invalid_argument(uri + ": no package named " + name + " below the search roots");
}

}  // namespace

MeshResolver packageResolver(const std::vector<std::string>& roots, const std::string& base_dir) {
  const auto searches = std::make_shared<std::vector<PackageSearch>>();
  for (const std::string& root : roots) searches->emplace_back(root);
  return [searches, base = fs::path(base_dir)](const std::string& uri) {
    fs::path path;
    if (startsWith(uri, kPackage)) {
      path = packageFile(uri, *searches);
    } else if (startsWith(uri, kFile)) {
      path = uri.substr(kFile.size());
      if (!path.is_absolute()) throw std::invalid_argument(uri + ": expected file:///<absolute path>");
    } else if (uri.find("://") == std::string::npos) {
      path = base / uri;
    } else {
      throw std::invalid_argument(uri + ": only package://, file:// and plain paths are known");
    }
    if (std::error_code failed; !fs::is_regular_file(path, failed)) {
      throw std::invalid_argument(uri + ": no such file: " + path.string());
    }
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
  std::istringstream list(variable ? variable : "");
  for (std::string root; std::getline(list, root, ':');) {
    if (!root.empty()) roots.push_back(root);
  }
  return roots;
}

}  // namespace proximity_server::scene
