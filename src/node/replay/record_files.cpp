#include "node/replay/record_files.h"

#include "node/replay/record_reader.h"
#include "system/whole_file.h"

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace proximity_server::node {
namespace {

/// The text as an attribute of XML, in quotes.
std::string xmlOf(const std::string& text) {
  std::string attribute = "\"";
  for (const char letter : text) {
    if (letter == '&')
      attribute += "&amp;";
    else if (letter == '<')
      attribute += "&lt;";
    else if (letter == '"')
      attribute += "&quot;";
    else
      attribute += letter;
  }
  return attribute + '"';
}

/// One stretch that is being written.
class Stretch {
 public:
  Stretch(const RecordReader& reader, std::string folder) : robot_(reader.robot) {
    files_.folder = std::move(folder);
    files_.mesh_tolerance = robot_->config().model.mesh_tolerance;
    requireTable();
    std::filesystem::create_directories(files_.folder);
    write("robot.urdf", robot_->texts()[0].urdf);
    write("robot.srdf", srdf());
    write("objects.yaml", reader.objects_text.empty() ? "[]\n" : reader.objects_text);
    states_ << std::setprecision(std::numeric_limits<double>::max_digits10);
  }

  /// Leaves out a cycle without all poses of the first one.
  void add(const RecordedCycle& cycle) {
    const sensor_msgs::JointState joints = jointsOf(*robot_, cycle, {});
    if (cycle.clearance.level == Clearance::INVALID || joints.name.empty()) return;
    if (files_.states == 0) {
      names_ = joints.name;
      states_ << "time";
      for (const std::string& name : names_) states_ << ',' << std::quoted(name, '"', '"');
      states_ << '\n';
    }
    if (joints.name != names_) return;
    ++files_.states;
    states_ << joints.header.stamp.toSec();
    for (const double position : joints.position) states_ << ',' << position;
    states_ << '\n';
  }

  RecordFiles end() {
    write("states.csv", states_.str());
    return files_;
  }

 private:
  void requireTable() const {
    if (robot_->texts().size() != 1) throw std::invalid_argument("files are of one robot, and it has several");
    for (const scene::Joint& joint : robot_->robotModel().joints)
      if (!scene::hasOnePosition(joint))
        throw std::invalid_argument("joint '" + joint.name +
                                    "' has no single position, so there is no table of states");
  }

  void write(const char* name, const std::string& text) const { system::replaceFile(files_.folder + "/" + name, text); }

  std::string srdf() const {
    std::ostringstream text;
    text << "<robot name=" << xmlOf(robot_->robotModel().name) << ">\n";
    for (const scene::LinkPair& pair : robot_->sceneModel().pairs.pairs)
      if (pair.reason != scene::PairReason::Checked)
        text << "  <disable_collisions link1=" << xmlOf(linkName(pair.link_a))
             << " link2=" << xmlOf(linkName(pair.link_b)) << " reason=\"" << scene::toString(pair.reason) << "\"/>\n";
    text << "</robot>\n";
    return text.str();
  }
  const std::string& linkName(int link) const { return robot_->robotModel().links[link].name; }

  const std::shared_ptr<const Robot> robot_;
  RecordFiles files_;
  std::vector<std::string> names_;
  std::ostringstream states_;
};

}  // namespace

std::vector<RecordFiles> writeFiles(const ReplayOptions& options, const std::string& folder) {
  std::vector<RecordFiles> written;
  std::optional<Stretch> stretch;
  const auto end = [&] {
    if (stretch) written.push_back(stretch->end());
  };
  RecordReader reader(options.file, {options.mesh_tolerance});
  reader.read([&](const RecordedCycle& cycle) {
    if (reader.is_new) {
      end();
      stretch.emplace(reader, folder + "/" + std::to_string(written.size() + 1));
    }
    stretch->add(cycle);
  });
  end();
  const bool has_states =
      std::any_of(written.begin(), written.end(), [](const RecordFiles& files) { return files.states > 0; });
  if (!has_states) throw std::invalid_argument(options.file + ": no cycle has known poses");
  return written;
}

}  // namespace proximity_server::node
