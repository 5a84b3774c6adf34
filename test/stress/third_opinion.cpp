#include "stress/third_opinion.h"

#include "peers/aborts.h"
#include "peers/libraries.h"
#include "stress/random_geometry.h"

#include <cmath>
#include <map>
#include <mutex>
#include <string>

namespace proximity_server::narrowphase {

using namespace peers;

std::vector<double> distancesByOthers(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  const std::optional<Solid> solid_a = solidOf(a), solid_b = solidOf(b);
  if (!solid_a || !solid_b) return {};
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  surviveAborts();
  std::map<std::string, double> found;
  for (const Library& library : allLibraries()) {
    if (library.name == "ours") continue;
    const SolidPair pair{&*solid_a, &*solid_b, peers::Placement::Apart, a_T_b};
    if (!library.answers(peers::Question::Distance, /*overlap=*/false)) continue;
    WarmStart warm;
    const auto answer = answerOf([&] { return library.ask(pair, peers::Question::Distance, kDefaultTolerance, warm); });
    if (answer && std::isfinite(answer->distance)) found[library.name] = answer->distance;
  }
  std::vector<double> distances;
  if (found.count("FCL libccd") > 0) distances.push_back(found["FCL libccd"]);
  constexpr double kFloat = 1e-6;  // some float eps
  const double scale = radiusOf(a) + radiusOf(b) + a_T_b.translation().norm();
  if (found.count("Bullet GJK") + found.count("Bullet EPA2") == 2 &&
      std::abs(found["Bullet GJK"] - found["Bullet EPA2"]) <= kFloat * scale)
    distances.push_back(found["Bullet EPA2"]);
  return distances;
}

}  // namespace proximity_server::narrowphase
