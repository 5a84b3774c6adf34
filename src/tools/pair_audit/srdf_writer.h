#pragma once

#include "tools/pair_audit/pair_study.h"

#include <string>

namespace proximity_server::tools {

/// An SRDF whose disable_collisions name the pairs that are always in contact ("Always"), those that are never near
/// ("Never"), and the neighbours ("Adjacent"). A pair that was seen near is among them only if it is always in contact,
/// or if they are neighbours that were not seen both apart and in contact.
///
/// Everything else of the given SRDF is kept, also its comments; "" stands for an empty SRDF. A pair that its
/// enable_collisions name is not disabled.
/// Failure: throws std::invalid_argument if the SRDF is not XML with a <robot>.
std::string writeSrdf(const std::string& srdf_xml, const scene::RobotModel& robot, const PairStudy& study);

}  // namespace proximity_server::tools
