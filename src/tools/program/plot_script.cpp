#include "tools/program/plot_script.h"

#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace proximity_server::tools {
namespace {

/// Runs Debian's Python, which has Debian's matplotlib, with this standard output, and returns whether it exited with 0.
/// It uses no shell, because file names may contain any characters.
bool runPython(std::vector<std::string> arguments, int output) {
  arguments.insert(arguments.begin(), "/usr/bin/python3");
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t streams;
  posix_spawn_file_actions_init(&streams);
  posix_spawn_file_actions_adddup2(&streams, output, STDOUT_FILENO);
  pid_t child = 0;
  const int failed = posix_spawn(&child, pointers[0], &streams, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&streams);
  if (failed != 0) return false;
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// The format by the suffix of the name. Throws std::invalid_argument for any other suffix.
std::string formatOf(const std::string& picture, const PlotKind& kind) {
  std::string format = std::filesystem::path(picture).extension();
  for (char& letter : format) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  const std::vector<std::string>& suffixes = kind.suffixes;
  if (std::find(suffixes.begin(), suffixes.end(), format) != suffixes.end()) return format.substr(1);
  std::string names = suffixes.front();
  for (std::size_t i = 1; i < suffixes.size(); ++i) names += (i + 1 < suffixes.size() ? ", " : " and ") + suffixes[i];
  throw std::invalid_argument(kind.option + ": " + picture + ": the name " +
                              (suffixes.size() > 1 ? "ends in none of " : "does not end in ") + names);
}

std::string besideExecutable(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

}  // namespace

PlotScript::PlotScript(const PlotKind& kind, const std::string& picture)
    : option_(kind.option),
      format_(formatOf(picture, kind)),
      script_(besideExecutable(kind.script)),
      picture_(picture) {
  if (!std::filesystem::exists(script_)) throw std::invalid_argument(option_ + ": there is no " + script_);
  if (!runPython({script_}, STDERR_FILENO)) {
    throw std::invalid_argument(option_ +
                                ": /usr/bin/python3 cannot use matplotlib (Debian package python3-matplotlib)");
  }
  std::string path = std::filesystem::temp_directory_path() / "plot_XXXXXX";
  const int file = mkstemp(path.data());
  if (file < 0) throw std::invalid_argument(option_ + ": no temporary file in " + path);
  close(file);
  data_path_ = path;
  data_.open(data_path_, std::ios::binary);
}

PlotScript::~PlotScript() {
  std::error_code ignored;
  std::filesystem::remove(data_path_, ignored);
}

void PlotScript::draw(const std::vector<std::string>& more_arguments) {
  data_.close();
  std::vector<std::string> arguments{script_, data_path_, format_};
  arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
  if (!runPython(std::move(arguments), picture_.descriptor()))
    throw std::invalid_argument(option_ + ": " + picture_.path() + " could not be drawn");
  picture_.complete();
}

}  // namespace proximity_server::tools
