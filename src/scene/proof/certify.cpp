#include "proximity_server/scene/proof/certify.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/certificate/verify.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/certificate/pair_separation.h"
#include "scene/guaranteed/place_to_halve.h"
#include "scene/model/numbers.h"
#include "scene/proof/pair_certificate.h"
#include "scene/scene_model/given_model.h"
#include "system/pipeline.h"

#include <algorithm>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using narrowphase::Shape;

/// Writes the certificate of one pair.
class CertificateWriter {
 public:
  CertificateWriter(const SceneModel& model, const PairProof& proof, const ProofQuestion& question)
      : model_(model), proof_(proof), question_(question), separation_(model, question.objects.get(), proof.pair) {}

  std::optional<PairCertificate> write(long most_nodes) {
    PairCertificate certificate{proof_.pair, kInfinity, {}};
    std::vector<JointBox> open{proof_.box};  // the parts that are not in the tree yet, the next one at the end
    while (!open.empty()) {
      const bool is_over = static_cast<long>(certificate.tree.size()) >= most_nodes || question_.deadline.hasPassed();
      if (is_over) return std::nullopt;
      const JointBox box = std::move(open.back());
      open.pop_back();
      const double least = separate(box);
      if (isEnough(least)) {
        certificate.bound = std::min(certificate.bound, lowered(least));
        certificate.tree.push_back({-1, 0.0, axes_});
        continue;
      }
      const int place = hindrance(box);
      if (place < 0) return std::nullopt;
      const JointRange divided = box[static_cast<std::size_t>(place)];
      const double middle = 0.5 * (divided.lower + divided.upper);
      certificate.tree.push_back({divided.joint, middle});
      open.push_back(withInterval(box, {divided.joint, middle, divided.upper}));
      open.push_back(withInterval(box, {divided.joint, divided.lower, middle}));
    }
    if (flawIn(certificate, proof_.box, model_, question_.objects.get())) return std::nullopt;
    return certificate;
  }

 private:
  /// [m] What a certificate states of a separation: a thousandth less.
  double lowered(double separation) const {
    const double contact = question_.contact_distance;
    return contact + 0.999 * (separation - separation_.padding() - contact);
  }
  bool isEnough(double separation) const { return lowered(separation) > question_.contact_distance; }

  /// Finds axes that separate the two in a box. Returns the least separation [m]. If it is not enough, it is the
  /// separation of the pieces a_ and b_ along the last axis; without axes, of the half-spaces.
  double separate(const JointBox& box) {
    axes_.clear();
    const double from_half_spaces = separation_.fromHalfSpaces(box);
    MatrixXd separations = separation_.along(axes_, box);
    if (!isEnough(from_half_spaces) || separations.size() == 0) return from_half_spaces;
    place(box);
    findNearest();
    for (double least = -kInfinity; !isEnough(least); least = separations.minCoeff(&a_, &b_)) {
      axes_.push_back(bestAxis(box));
      separations = separations.cwiseMax(separation_.along({axes_.back()}, box));
      if (!isEnough(separations(a_, b_))) return separations(a_, b_);
    }
    return std::min(from_half_spaces, separations.minCoeff());
  }

  /// Takes the poses in the middle of a box.
  void place(const JointBox& box) {
    Positions positions(model_.robot.joints.size(), 0.0);
    for (const JointRange& interval : box) positions[interval.joint] = 0.5 * (interval.lower + interval.upper);
    poses_ = forwardKinematics(model_.robot, positions);
  }

  Isometry3d poseOf(const CarriedShape& side, Eigen::Index piece) const {
    return *poses_[side.body] * side.pieces[static_cast<std::size_t>(piece)].body_T_piece;
  }
  static const Shape& shapeOf(const CarriedShape& side, Eigen::Index piece) {
    return side.pieces[static_cast<std::size_t>(piece)].piece->shape;
  }

  /// Takes the two pieces with the nearest bounding balls.
  void findNearest() {
    double least = kInfinity;
    for (std::size_t i = 0; i < separation_.a().pieces.size(); ++i) {
      for (std::size_t k = 0; k < separation_.b().pieces.size(); ++k) {
        const double apart = apartByBalls(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
        if (!(apart < least)) continue;
        least = apart;
        a_ = static_cast<Eigen::Index>(i);
        b_ = static_cast<Eigen::Index>(k);
      }
    }
  }

  double apartByBalls(Eigen::Index a, Eigen::Index b) const {
    const Shape &shape_a = shapeOf(separation_.a(), a), &shape_b = shapeOf(separation_.b(), b);
    const Vector3d between =
        poseOf(separation_.b(), b) * shape_b.centre() - poseOf(separation_.a(), a) * shape_a.centre();
    return between.norm() - shape_a.coreRadius() - shape_a.margin() - shape_b.coreRadius() - shape_b.margin();
  }

  /// The axis of the pieces a_ and b_ in the middle of the box, fixed to the body for which it separates them best.
  SeparatingAxis bestAxis(const JointBox& box) const {
    const Isometry3d pose = poseOf(separation_.a(), a_);
    const Isometry3d a_T_b = pose.inverse(Eigen::Isometry) * poseOf(separation_.b(), b_);
    const Vector3d normal =
        pose.linear() * signedDistance(shapeOf(separation_.a(), a_), shapeOf(separation_.b(), b_), a_T_b).normal;
    SeparatingAxis best{};
    double most = -kInfinity;
    for (const int body : separation_.bodies()) {
      const SeparatingAxis axis{model_.robot.bodies[body].link, poses_[body]->linear().transpose() * normal};
      const double separated = along(axis, box);
      if (body != separation_.bodies().front() && !(separated > most)) continue;
      most = separated;
      best = axis;
    }
    return best;
  }

  double along(const SeparatingAxis& axis, const JointBox& box) const {
    return separation_.along(axis, box, static_cast<int>(a_), static_cast<int>(b_));
  }

  /// The place of the joint whose motion keeps the two from being separated the most; -1 if no interval can be halved.
  int hindrance(const JointBox& box) const {
    return placeToHalve(box.data(), box.size(), [&](const JointRange& interval) {
      const double middle = 0.5 * (interval.lower + interval.upper);
      const JointBox still = withInterval(box, {interval.joint, middle, middle});
      return axes_.empty() ? separation_.fromHalfSpaces(still) : along(axes_.back(), still);
    });
  }

  const SceneModel& model_;
  const PairProof& proof_;
  const ProofQuestion& question_;
  const PairSeparation separation_;
  BodyPoses poses_;  ///< in the middle of a box
  std::vector<SeparatingAxis> axes_;
  Eigen::Index a_ = 0, b_ = 0;  ///< two pieces that the axes do not separate
};

}  // namespace

std::optional<PairCertificate> certificateOf(const PairProof& proof, const SceneModel& model,
                                             const ProofQuestion& question, long most_nodes) {
  return CertificateWriter(model, proof, question).write(most_nodes);
}

std::vector<std::optional<PairCertificate>> certify(const std::shared_ptr<const SceneModel>& model,
                                                    const std::vector<PairProof>& proofs, const ProofQuestion& asked) {
  given(model);
  ProofQuestion question = asked;
  question.deadline = asked.deadline.withoutTime();
  std::vector<std::optional<PairCertificate>> certificates(proofs.size());
  std::size_t next = 0, done = 0;
  const auto read = [&](std::size_t& proof) { return (proof = next++) < proofs.size(); };
  const auto work = [&](std::size_t& proof, int) {
    if (proofs[proof].outcome == ProofOutcome::Proven)
      certificates[proof] = certificateOf(proofs[proof], *model, question, question.most_boxes);
  };
  const auto tell = [&](std::size_t&) {
    if (question.progress) question.progress(static_cast<double>(++done) / static_cast<double>(proofs.size()));
  };
  system::runPipeline<std::size_t>({read, work, tell}, {question.threads});
  return certificates;
}

}  // namespace proximity_server::scene
