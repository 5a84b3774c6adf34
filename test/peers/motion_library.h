#pragma once

#include "peers/moving_solids.h"

#include <fcl/narrowphase/gjk_solver_type.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace proximity_server::peers {

/// The answer of a library about a moving pair.
struct ContactAnswer {
  bool contact = false;
  bool decided = true;  ///< false: there may be a contact after t_free
  double t_free = 1.0;  ///< no contact before this time; if the library samples: the last sample without
  double t_contact = std::numeric_limits<double>::quiet_NaN();
  int queries = 0;  ///< of a distance, if the library tells
};

/// A way to ask for the time of contact.
struct ContactLibrary {
  std::string name;
  double setting;  ///< the tolerance [m], FCL's error of the time, or the number of samples
  std::function<ContactAnswer(const MovingSolidPair& pair)> ask;
};

ContactLibrary oursWithin(double tolerance);
ContactLibrary sweptBisectionWithin(double tolerance);

/// FCL's continuousCollide by conservative advancement. For shapes it takes no setting: both fields of the request go
/// unread (conservative_advancement_func_matrix-inl.h, ShapeConservativeAdvancement), and the error of the time is the
/// 1e-4 that its node begins with; only the solver of the distance is chosen. It misses contacts at which it arrives
/// within rounding: the line between the nearest points, 1e-16 m long, then has any direction, and where the bound of
/// the motion along it is negative the step is the whole motion (shape_conservative_advancement_traversal_node-inl.h,
/// leafTesting).
ContactLibrary fclAdvancement(fcl::GJKSolverType solver);

/// Advancement with libccd and another error of the time: FCL's node in a loop like FCL's own. Only where both solids
/// are of one kind (box, capsule, cylinder or hull).
ContactLibrary fclAdvancementWithin(double time_error);

/// FCL's continuousCollide by sampling.
ContactLibrary fclNaive(int samples);

/// Our narrowphase at so many times, apart or not, with warm starts, until the first contact.
ContactLibrary samplingBy(int samples);

/// Returns each as it is used without a thought about its settings.
std::vector<ContactLibrary> contactLibraries();

/// Returns all of them that take a setting, with several settings.
std::vector<ContactLibrary> tunedContactLibraries();

/// The answer of a library about the smallest signed distance during a motion.
struct MinimumAnswer {
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< if there is a proof
  double distance = std::numeric_limits<double>::quiet_NaN();
  int queries = 0;
};

struct MinimumLibrary {
  std::string name;
  double setting;  ///< the tolerance [m], or the number of samples
  std::function<MinimumAnswer(const MovingSolidPair& pair)> ask;
};

/// Returns minimumDistance() with several tolerances, and samples of the distance with warm starts.
std::vector<MinimumLibrary> minimumLibraries();

}  // namespace proximity_server::peers
