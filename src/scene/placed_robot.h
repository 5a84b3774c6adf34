#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "bounds.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/scene.h"
#include "warm_starts.h"

namespace proximity_server {

/// A robot in one set of poses: what bounds and narrowphase say about its parts.
///
/// A volume is a set of pieces of one body. They are numbered: the pieces of the model first, with their own indices,
/// then its links, then its <collision> elements.
/// Frame: that of the poses. Only the difference of two bodies' origins enters a distance, so that the same robot far
///        from the frame's origin gives the same answer.
class PlacedRobot {
 public:
  explicit PlacedRobot(const RobotModel& model);

  /// A pose that is not finite, or whose matrix is no rotation within single precision, counts as missing. Throws
  /// std::invalid_argument where there is not one pose for each body.
  void update(const BodyPoses& poses);

  /// Throws std::invalid_argument for a link or <collision> that does not exist.
  int volumeOf(const Subject& subject) const;

  /// Has geometry, at a known pose.
  bool isPlaced(int volume) const;

  const std::vector<int>& piecesOf(int volume) const { return at(volume).pieces; }
  Representation representationOf(int volume) const { return at(volume).representation; }

  /// Lower bounds [m] of the signed distance of two volumes.
  double sphereGap(int a, int b) const;
  double boxGap(int a, int b) const;

  /// Whether boxGap costs less than the query that it may save.
  bool boxesPay(int a, int b) const { return !at(a).closed_form || !at(b).closed_form; }

  /// The certified distance of two pieces; the bounds allow for the rounding of the poses, also where they decide
  /// a threshold. The same numbers come out, turned round, for the pieces in the other order.
  SignedDistance distance(int piece_a, int piece_b, const Options& options, WarmStarts& warm_starts) const;

 private:
  struct Volume {
    int body;
    std::vector<int> pieces;
    Representation representation;
    Bounds bounds;
    bool closed_form;                                  ///< a single sphere or capsule
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< from the body's origin to the bounds' centre
  };
  struct BodyPlace {
    bool known = false;
    Eigen::Matrix3d rotation;
    Eigen::Vector3d origin;
  };
  struct PiecePlace {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d offset;  ///< from the body's origin
  };

  const Volume& at(int volume) const { return volumes_[static_cast<std::size_t>(volume)]; }
  const BodyPlace& bodyOf(int volume) const { return bodies_[static_cast<std::size_t>(at(volume).body)]; }
  const Piece& piece(int index) const { return model_.pieces[static_cast<std::size_t>(index)]; }
  const PiecePlace& placeOf(int piece) const { return pieces_[static_cast<std::size_t>(piece)]; }
  Eigen::Vector3d between(int a, int b) const;

  void addPieceVolumes();
  void addVolume(int link, std::vector<int> pieces);
  std::vector<int> piecesOfLink(const Link& link) const;

  const RobotModel& model_;
  std::vector<Volume> volumes_;
  std::vector<BodyPlace> bodies_;
  std::vector<PiecePlace> pieces_;
};

}  // namespace proximity_server
