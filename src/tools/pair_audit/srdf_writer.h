#pragma once

#include <string>

#include "tools/pair_audit/pair_study.h"

namespace proximity_server::tools {

/// An SRDF whose disable_collisions name the pairs that are always in contact ("Always"), those that never are
/// ("Never"), and the neighbours ("Adjacent") but for those that were seen both apart and in contact: such a pair is
/// never written.
///
/// Everything else of the given SRDF stays, comments too; "" stands for an SRDF that says nothing. A pair that its
/// enable_collisions name is not disabled.
/// Failure: throws std::invalid_argument for an SRDF that is no XML with a <robot>.
std::string writeSrdf(const std::string& srdf_xml, const scene::RobotModel& robot, const PairStudy& study);

}  // namespace proximity_server::tools
