#pragma once

#include "tools/pair_audit/level_shares.h"
#include "tools/pair_audit/pair_study.h"

#include <string>
#include <vector>

namespace proximity_server::tools {

/// An SRDF whose disable_collisions name the pairs that are always in contact ("Always"), those that are never within
/// PairEvidence::measured ("Never"; the entry of one that is not proven has what was seen), and the neighbours
/// ("Adjacent"). A pair that was seen near is among them only if it is always in contact,
/// or if they are neighbours that were not seen both apart and in contact.
///
/// Everything else of the given SRDF is kept, also its comments; "" stands for an empty SRDF. A pair that its
/// enable_collisions name is not disabled.
/// Failure: throws std::invalid_argument if the SRDF is not XML with a <robot>.
std::string writeSrdf(const std::string& srdf_xml, const scene::RobotModel& robot, const PairStudy& study);

/// The entry of an SRDF that disables a pair by decision, because of its contacts.
std::string disablingEntry(const scene::RobotModel& robot, const PairLevels& pair);

/// The SRDF with these entries at its end; the same text if there are none. Failure: throws as writeSrdf() does.
std::string withDisabled(const std::string& srdf_xml, const scene::RobotModel& robot,
                         const std::vector<PairLevels>& pairs);

}  // namespace proximity_server::tools
