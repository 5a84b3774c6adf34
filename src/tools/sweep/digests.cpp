#include "tools/sweep/digests.h"

#include "tools/text/content_hash.h"

#include <link.h>

#include <cmath>
#include <limits>

namespace proximity_server::tools {
namespace {

/// A ContentHash that takes numbers, too: every NaN counts as the same, and -0 as 0.
class Digest {
 public:
  void add(double number) {
    if (std::isnan(number)) number = std::numeric_limits<double>::quiet_NaN();
    if (number == 0.0) number = 0.0;
    hash_.add(&number, sizeof number);
  }
  void add(int number) { add(static_cast<double>(number)); }
  void add(const std::string& text) { hash_.add(text); }
  std::string text() const { return hash_.text(); }

 private:
  ContentHash hash_;
};

void add(const Eigen::Isometry3d& pose, Digest& digest) {
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) digest.add(pose.matrix()(row, column));
}

void add(const Eigen::Vector3d& vector, Digest& digest) {
  for (int i = 0; i < 3; ++i) digest.add(vector[i]);
}

void add(const scene::Joint& joint, Digest& digest) {
  digest.add(joint.name);
  digest.add(static_cast<int>(joint.type));
  digest.add(joint.parent_link);
  digest.add(joint.child_link);
  add(joint.parent_T_joint, digest);
  add(joint.axis, digest);
  digest.add(joint.lower);
  digest.add(joint.upper);
  const scene::Joint::Mimic mimic = joint.mimic.value_or(scene::Joint::Mimic{-1, 0.0, 0.0});
  digest.add(mimic.joint);
  digest.add(mimic.multiplier);
  digest.add(mimic.offset);
}

std::string jointsOf(const scene::RobotModel& robot) {
  Digest digest;
  for (const scene::Link& link : robot.links) {
    digest.add(link.name);
    digest.add(link.body);
    add(link.body_T_link, digest);
  }
  for (const scene::Joint& joint : robot.joints) add(joint, digest);
  for (const scene::Body& body : robot.bodies) {
    digest.add(body.link);
    digest.add(body.joint);
    digest.add(body.parent);
  }
  return digest.text();
}

void add(const narrowphase::Shape& shape, Digest& digest) {
  digest.add(static_cast<int>(shape.kind()));
  digest.add(shape.margin());
  if (shape.kind() != narrowphase::Shape::Kind::Hull) return add(shape.halfExtents(), digest);
  for (const Eigen::Vector3d& vertex : shape.hull().vertices()) add(vertex, digest);
}

void add(const std::vector<scene::Piece>& pieces, Digest& digest) {
  for (const scene::Piece& piece : pieces) {
    add(piece.shape, digest);
    add(piece.body_T_piece, digest);
    digest.add(piece.collision);
    digest.add(piece.is_representative ? 1 : 0);
    digest.add(piece.interior ? 1 : 0);
  }
}

/// A <collision> of a link or a shape of an object.
template <typename Measured>
void addMeasures(const Measured& shape, Digest& digest) {
  digest.add(static_cast<int>(shape.representation));
  digest.add(shape.deviation);
  digest.add(shape.uncovered);
  digest.add(shape.volume_ratio);
}

std::string shapesOf(const scene::RobotModel& robot) {
  Digest digest;
  add(robot.pieces, digest);
  for (const scene::Collision& collision : robot.collisions) {
    digest.add(collision.link);
    addMeasures(collision, digest);
  }
  return digest.text();
}

std::string pairsOf(const scene::PairTable& table) {
  Digest digest;
  for (const scene::LinkPair& pair : table.pairs) {
    digest.add(pair.link_a);
    digest.add(pair.link_b);
    digest.add(static_cast<int>(pair.reason));
    digest.add(pair.padding);
  }
  return digest.text();
}

int addOurLibrary(dl_phdr_info* object, std::size_t /*size*/, void* files) {
  const std::string path = object->dlpi_name;
  if (path.find("libproximity_") != std::string::npos) static_cast<std::vector<std::string>*>(files)->push_back(path);
  return 0;
}

}  // namespace

ModelDigest digestOf(const scene::SceneModel& model) {
  return {jointsOf(model.robot), shapesOf(model.robot), pairsOf(model.pairs)};
}

std::string digestOf(const scene::LevelThresholds& thresholds, const scene::RobotModel& robot) {
  Digest digest;
  const auto add = [&](const scene::ShapeRefPair& pair) {
    digest.add(thresholds.stop.of(pair));
    digest.add(thresholds.warn.of(pair));
  };
  const int links = static_cast<int>(robot.links.size());
  for (int a = 0; a < links; ++a) {
    add({{a}, scene::ShapeRef::ofObject(0)});
    for (int b = a + 1; b < links; ++b) add({{a}, {b}});
  }
  return digest.text();
}

std::string shapesDigestOf(const std::vector<scene::Object>& objects) {
  Digest digest;
  for (const scene::Object& object : objects) {
    digest.add(object.id);
    add(scene::piecesOf(object), digest);
    for (const scene::ObjectShapeInfo& shape : scene::shapesOf(object)) addMeasures(shape, digest);
  }
  return digest.text();
}

std::string programDigest() {
  std::vector<std::string> files{"/proc/self/exe"};
  dl_iterate_phdr(addOurLibrary, &files);
  ContentHash hash;
  for (const std::string& file : files) hash.add(contentHash(file));
  return hash.text();
}

}  // namespace proximity_server::tools
