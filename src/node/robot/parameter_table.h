#pragma once

#include "node/robot/config.h"

#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace proximity_server::node {

/// The interval of the numbers that a parameter may have; both ends belong to it.
struct Range {
  double lowest = 0.0, highest = 0.0;

  std::string text() const;  ///< "[0, 100]"
};

/// A row of the table of parameters. The node reads its parameters by these rows, and `./dev parameters` makes the
/// table of config/PARAMETERS.md, config/proximity.yaml and config/Proximity.cfg from them.
struct Parameter {
  /// The moment from which a new value counts: at once (dynamic_reconfigure), with the service ~reload, or at the next
  /// start of the node.
  enum class Change : unsigned char { Live, Reload, Start };

  using Names = scene::PairFilterOptions::Names;
  using Field = std::variant<double*, int*, bool*, std::string*, std::vector<std::string>*, std::vector<Names>*,
                             std::vector<std::pair<Names, double>>*, std::map<std::string, double>*, JointLimits*,
                             std::vector<RobotSource>*, scene::ObjectFile*, scene::ObjectRules::FreeObjects*,
                             scene::FileValue*, PoseLatency*>;

  std::string name;
  Field field;       ///< points into the configuration of the table; it begins with the default
  Range range;       ///< the range of each number in the field, if there are any
  std::string unit;  ///< "" if it has none
  Change change;
  std::string text;     ///< in Markdown; dynamic_reconfigure shows only the first sentence
  std::string heading;  ///< heading of the rows from this one on; "" if the heading above stays
};

/// Returns all parameters, each with its field in `config`. A live parameter is a field of MonitorSettings.
std::vector<Parameter> parameterTable(Config& config);

}  // namespace proximity_server::node
