#pragma once

#include "peers/solids.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <limits>
#include <string>
#include <vector>

namespace proximity_server::peers {

using namespace narrowphase;

enum class Question {
  Distance,  ///< signed distance with witness points; libraries that tell overlap and distance apart are asked the
             ///< right one
  Boolean    ///< apart or not
};

/// The answer of a library about a pair: the signed distance [m]; for Boolean any positive number for apart, else a
/// negative.
struct Answer {
  double distance = std::numeric_limits<double>::quiet_NaN();
  int iterations = 0;  ///< if the library tells
};

/// A library and the way it is asked. Sources: FCL 0.7, libccd 2.1, Bullet 3.24 as Debian packages them.
struct Library {
  std::string name;
  bool has_tolerance;                                ///< takes one
  bool (*answers)(Question question, bool overlap);  ///< a question, of pairs that overlap or do not
  /// `warm` is what the last query of the same two solids left behind; a library without warm starts ignores it.
  Answer (*ask)(const SolidPair& pair, Question question, double tolerance, WarmStart& warm);
};

/// Returns ours, FCL with each of its solvers, libccd alone, and both ways into Bullet.
std::vector<Library> allLibraries();

/// Returns ours, asked less and less of a pair: the names are the questions.
std::vector<Library> oursAskedLess();

constexpr double kDefaultTolerance = 0.0;  ///< that of the library

}  // namespace proximity_server::peers
