// Answers the states of a record again. `clearance --replay` starts it.
#include "node/replay/record_files.h"
#include "node/replay/replay.h"
#include "proximity_server/scene/model/names.h"
#include "system/number_text.h"
#include "system/whole_file.h"

#include <ros/console.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using proximity_server::node::ReplayOptions;

constexpr char kHelp[] =
    "usage: clearance --replay FILE.bag [--mesh-tolerance METRES] [--quiet] [--out FILE] "
    "[--explain-event | --write-files DIR |\n"
    "                                    --second-opinion LIBRARY | --report FILE.html]\n"
    "  --mesh-tolerance METRES  in place of that of the record; 0: triangles\n"
    "  --quiet                  no warnings of the model\n"
    "  --out FILE               where the rows go, or the text of --explain-event (default: standard output)\n"
    "  --explain-event          contact, or the envelope around the surfaces: each share in millimetres\n"
    "  --write-files DIR        robot, pairs, objects and states for the other tools: DIR/1, and a folder more for\n"
    "                           each change of the objects\n"
    "  --second-opinion LIBRARY fcl: what it says of the five closest pairs of each state, without padding\n"
    "  --report FILE.html       a page about the distances in its states, and their files in FILE_files; where "
    "objects\n"
    "                           change, another page (FILE_2.html) begins\n"
    "A row for each cycle. Exit code 2: a level or bounds differ from the record.\n"
    "3: an answer of ours is refuted.\n";

/// Runs the program beside this one, and returns its exit code.
int runBeside(const std::string& name, std::vector<std::string> arguments) {
  const std::string program = fs::read_symlink("/proc/self/exe").parent_path() / name;
  arguments.insert(arguments.begin(), program);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    execv(program.c_str(), pointers.data());
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) == 127)
    throw std::runtime_error(program + " cannot be run");
  return WEXITSTATUS(status);
}

/// Calls `clearance` with the files of a record and with further arguments, and returns its exit code.
int askClearance(const proximity_server::node::RecordFiles& files, const std::vector<std::string>& more) {
  const std::string begin = files.folder + "/";
  std::vector<std::string> arguments{begin + "robot.urdf",
                                     "--srdf",
                                     begin + "robot.srdf",
                                     "--objects",
                                     begin + "objects.yaml",
                                     "--states",
                                     begin + "states.csv",
                                     "--mesh-tolerance",
                                     proximity_server::scene::shortest(files.mesh_tolerance),
                                     "--out",
                                     "/dev/null",
                                     "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return runBeside("clearance", arguments);
}

/// Writes a page about each stretch of a record, beside the files that it is about. Returns the largest exit code.
int writeReports(const ReplayOptions& options, const fs::path& page) {
  const fs::path stem = fs::path(page).replace_extension();
  const std::string folder = stem.string() + "_files";
  fs::create_directory(folder);
  int code = 0, pages = 0;
  for (const proximity_server::node::RecordFiles& files : writeFiles(options, folder)) {
    if (files.states == 0) continue;
    const std::string number = ++pages > 1 ? "_" + std::to_string(pages) : "";
    code = std::max(code, askClearance(files, {"--report", stem.string() + number + page.extension().string()}));
  }
  return code;
}

/// Returns the largest exit code of `clearance`.
int askSecondOpinion(const ReplayOptions& options, const std::string& library) {
  std::string folder = (fs::temp_directory_path() / "proximity_replay_XXXXXX").string();
  if (!mkdtemp(folder.data())) throw std::runtime_error(folder + " cannot be made");
  int code = 0;
  try {
    for (const proximity_server::node::RecordFiles& files : writeFiles(options, folder))
      if (files.states > 0) code = std::max(code, askClearance(files, {"--pairs", "k:5", "--second-opinion", library}));
  } catch (const std::exception&) {
    fs::remove_all(folder);
    throw;
  }
  fs::remove_all(folder);
  return code;
}

void setLogLevel(ros::console::Level level) {
  if (ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, level)) ros::console::notifyLoggerLevelsChanged();
}

int run(int argc, char** argv) {
  ReplayOptions options;
  bool explains = false;
  std::string folder, library, page, out;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto value = [&]() -> std::string {
      if (++i == argc) throw std::invalid_argument(option + " needs a value\n" + kHelp);
      return argv[i];
    };
    if (option == "--replay")
      options.file = value();
    else if (option == "--mesh-tolerance")
      options.mesh_tolerance = std::stod(value());
    else if (option == "--explain-event")
      explains = true;
    else if (option == "--write-files")
      folder = value();
    else if (option == "--second-opinion")
      library = value();
    else if (option == "--report")
      page = value();
    else if (option == "--out")
      out = value();
    else if (option == "--quiet")
      setLogLevel(ros::console::levels::Error);
    else
      throw std::invalid_argument(option + " does not go with --replay\n" + kHelp);
  }
  proximity_server::system::FileRoles& roles = proximity_server::system::FileRoles::ofProcess();
  roles.addInput("--replay", options.file);
  if (!page.empty()) roles.addOutput("--report", page);
  if (!out.empty()) roles.addOutput("--out", out);
  if (!folder.empty()) {
    for (const auto& files : proximity_server::node::writeFiles(options, folder))
      std::cout << files.folder << ": " << files.states << " states\n";
    return 0;
  }
  if (!library.empty()) return askSecondOpinion(options, library);
  if (!page.empty()) return writeReports(options, page);
  std::ostringstream text;
  const auto writeText = [&] {
    if (!out.empty()) proximity_server::system::replaceFile(out, text.str());
  };
  std::ostream& to = out.empty() ? std::cout : text;
  if (explains) {
    to << proximity_server::node::explainEvent(options);
    writeText();
    return 0;
  }
  const auto result = proximity_server::node::replay(options, to);
  writeText();
  std::cerr << "clearance: " << result.cycles << " cycles, " << result.different << " differ from the record\n";
  if (result.coarse > 0)
    std::cerr << "clearance: in " << result.coarse << " of them a limit ended guaranteed distances\n";
  for (const std::string& line : result.first_coarse) std::cerr << "  " << line << '\n';
  if (result.agrees()) return 0;
  for (const std::string& line : result.first_differences) std::cerr << "  " << line << '\n';
  for (const std::string& reason : result.reasons) std::cerr << "  possible reason: " << reason << '\n';
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  setLogLevel(ros::console::levels::Warn);  // standard output is for rows, and ROS writes its info there
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "clearance: " << proximity_server::system::readable(error.what()) << '\n';
    return 1;
  }
}
