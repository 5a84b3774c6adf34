#include "scene/model/model_hash.h"

#include "system/fnv_hash.h"

#include <Eigen/Geometry>

namespace proximity_server::scene {
namespace {

class ModelHash {
 public:
  void add(const std::string& text) {
    hash_.add(text);
    add(static_cast<double>(text.size()));
  }
  void add(double number) {
    number += 0.0;  // -0 becomes 0
    hash_.add(&number, sizeof number);
  }
  template <typename Derived>
  void add(const Eigen::MatrixBase<Derived>& numbers) {
    for (Eigen::Index column = 0; column < numbers.cols(); ++column)
      for (Eigen::Index row = 0; row < numbers.rows(); ++row) add(numbers(row, column));
  }
  void add(const Eigen::Isometry3d& pose) { add(pose.matrix().topRows<3>()); }

  void add(const Joint& joint) {
    add(joint.name);
    for (const int number : {static_cast<int>(joint.type), joint.parent_link, joint.child_link}) add(number);
    add(joint.parent_T_joint);
    add(joint.axis);
    add(joint.lower);
    add(joint.upper);
    if (!joint.mimic) return add(-1);
    add(joint.mimic->joint);
    add(joint.mimic->multiplier);
    add(joint.mimic->offset);
  }

  void add(const Link& link) {
    add(link.name);
    add(link.body);
    add(link.body_T_link);
  }

  void add(const Piece& piece, int link) {
    const narrowphase::Shape& shape = piece.shape;
    add(link);
    add(static_cast<int>(shape.kind()));
    add(shape.margin());
    add(shape.halfExtents());
    if (shape.kind() == narrowphase::Shape::Kind::Hull)
      for (const Eigen::Vector3d& vertex : shape.hull().vertices()) add(vertex);
    add(piece.body_T_piece);
    add(piece.interior ? 1 : 0);
  }

  std::string text() const { return hash_.text(); }

 private:
  system::FnvHash hash_;
};

}  // namespace

std::string modelHash(const RobotModel& robot) {
  ModelHash hash;
  for (const Link& link : robot.links) hash.add(link);
  for (const Joint& joint : robot.joints) hash.add(joint);
  for (const Piece& piece : robot.pieces) hash.add(piece, robot.collisionOf(piece).link);
  return hash.text();
}

}  // namespace proximity_server::scene
