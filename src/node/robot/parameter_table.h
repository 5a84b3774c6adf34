#pragma once

#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "node/robot/config.h"

namespace proximity_server::node {

/// The numbers that a parameter may have, with both ends.
struct Range {
  double lowest = 0.0, highest = 0.0;

  std::string text() const;  ///< "[0, 100]"
};

/// A row of the table of parameters. The node reads its parameters by these rows, and the table of config/PARAMETERS.md,
/// config/proximity.yaml and config/Proximity.cfg are made of them: `./dev parameters`.
struct Parameter {
  /// When a new value counts: at once (dynamic_reconfigure), with the service ~reload, or at the next start of the node.
  enum class Change : unsigned char { Live, Reload, Start };

  using Names = scene::PairFilterOptions::Names;
  using Field = std::variant<double*, int*, bool*, std::string*, std::vector<std::string>*, std::vector<Names>*,
                             std::vector<std::pair<Names, double>>*, std::map<std::string, double>*, MaxDeceleration*,
                             std::vector<RobotSource>*, scene::ObjectFile*, scene::ObjectRules::FreeObjects*>;

  std::string name;
  Field field;       ///< in the configuration of the table; it begins with the default
  Range range;       ///< of each number in it, if there are any
  std::string unit;  ///< "": none
  Change change;
  std::string text;     ///< in Markdown; the first sentence is all that dynamic_reconfigure shows
  std::string heading;  ///< of the rows from here on; "": as above
};

/// All parameters, each with its field in `config`. A live one is a field of MonitorSettings.
std::vector<Parameter> parameterTable(Config& config);

}  // namespace proximity_server::node
