#include "proximity_server/scene/certificate/verify.h"

#include "proximity_server/scene/model/names.h"
#include "scene/certificate/pair_separation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proximity_server::scene {
namespace {

using Box = std::vector<JointRange>;
using Flaw = std::optional<std::string>;

/// Verifies the tree of a certificate.
class TreeCheck {
 public:
  TreeCheck(const PairCertificate& certificate, const RobotModel& robot, const PairSeparation& separation)
      : certificate_(certificate), robot_(robot), separation_(separation) {}

  Flaw flawIn(Box whole) const {
    std::vector<Box> open{std::move(whole)};  // the boxes whose trees follow, the next one at the end
    for (std::size_t i = 0; i < certificate_.tree.size(); ++i) {
      if (open.empty()) return "its tree is complete before node " + std::to_string(i + 1);
      const CertificateNode& node = certificate_.tree[i];
      const Box box = std::move(open.back());
      open.pop_back();
      const Flaw flaw = node.joint < 0 ? flawOfLeaf(node, box) : flawOfDivision(node, box);
      if (flaw) return "node " + std::to_string(i + 1) + ", where" + textOf(box) + ": " + *flaw;
      if (node.joint < 0) continue;
      const JointRange divided = *intervalOf(box, node.joint);
      open.push_back(withInterval(box, {node.joint, node.at, divided.upper}));
      open.push_back(withInterval(box, {node.joint, divided.lower, node.at}));
    }
    if (open.empty()) return std::nullopt;
    return "its tree ends before the part where" + textOf(open.back());
  }

 private:
  std::string textOf(const Box& box) const {
    std::string text;
    for (const JointRange& interval : box)
      text +=
          " " + robot_.joints[interval.joint].name + "=" + shortest(interval.lower) + ".." + shortest(interval.upper);
    return text;
  }

  Flaw flawOfDivision(const CertificateNode& node, const Box& box) const {
    const JointRange* interval = intervalOf(box, node.joint);
    if (interval && interval->lower < node.at && node.at < interval->upper) return std::nullopt;
    return "it divides " + robot_.joints[node.joint].name + " at " + shortest(node.at);
  }

  Flaw flawOfLeaf(const CertificateNode& leaf, const Box& box) const {
    constexpr double kShortest = 1e-100;  // the square of a shorter axis loses digits
    for (const SeparatingAxis& axis : leaf.axes) {
      const std::vector<int>& bodies = separation_.bodies();
      if (std::count(bodies.begin(), bodies.end(), robot_.links[axis.link].body) == 0)
        return "an axis is fixed to " + robot_.links[axis.link].name + ", which is not between the two";
      const double length = axis.direction.norm();
      if (!(length > kShortest && length < 1.0 / kShortest)) return "an axis has no direction";
    }
    const double least = separation_.least(leaf.axes, box) - separation_.padding();
    if (least >= certificate_.bound) return std::nullopt;
    return "its axes prove " + shortest(least) + " m, and the bound is " + shortest(certificate_.bound) + " m";
  }

  const PairCertificate& certificate_;
  const RobotModel& robot_;
  const PairSeparation& separation_;
};

}  // namespace

Flaw flawIn(const PairCertificate& certificate, const std::vector<JointRange>& box, const SceneModel& model,
            const Objects* objects) {
  const PairSeparation separation(model, objects, certificate.pair);
  if (!std::isfinite(certificate.bound)) return "its bound is not finite";
  Box whole;
  for (const int joint : separation.leaders()) {
    const std::string name = "joint " + quoted(model.robot.joints[joint].name);
    const JointRange* interval = intervalOf(box, joint);
    if (!interval) return name + " has no interval";
    if (!(interval->lower <= interval->upper) || !std::isfinite(interval->width()))
      return name + " has no finite interval";
    whole.push_back(*interval);
  }
  if (separation.hasInterior()) {
    if (certificate.bound + separation.padding() < 0.0) return "its bound lets the surfaces of closed meshes meet";
    if (!separation.isOutside(whole)) return "one of the two is inside of the other one in the middle of the box";
  }
  return TreeCheck(certificate, model.robot, separation).flawIn(whole);
}

}  // namespace proximity_server::scene
