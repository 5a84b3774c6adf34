#pragma once

#include "proximity_server/narrowphase/cso/query_trace.h"
#include "proximity_server/narrowphase/query_types.h"
#include "tools/explain/explained_pair.h"

#include <string>

namespace proximity_server::tools {

/// One query, its answer, and how it came about.
struct Explanation {
  ExplainedPair pair;
  narrowphase::SignedDistance answer;  ///< it is in the frame of a
  narrowphase::QueryTrace trace;
};

/// Asks the narrowphase. `first_direction`: where the search begins, from a to b; zero: where it begins by itself.
Explanation explain(const ExplainedPair& pair, const narrowphase::Options& options,
                    const Eigen::Vector3d& first_direction);

/// A row for each step, and the answer: numbers rounded for reading. All bounds are bounds of the signed distance of
/// the shapes, margins included.
std::string tableOf(const Explanation& explanation);

/// Whether jsonOf() adds what a picture needs: the surfaces of the shapes and of the CSO, as support mappings show them.
enum class CsoSurface : unsigned char { Omitted, Added };

/// Writes the explanation as JSON, with all digits; a number that is not finite is null.
std::string jsonOf(const Explanation& explanation, CsoSurface surface);

/// An algorithm as the end of a sentence "by ...".
std::string algorithmText(narrowphase::Algorithm algorithm);

std::string statusText(narrowphase::Status status);

}  // namespace proximity_server::tools
