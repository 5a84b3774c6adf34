#pragma once

#include "proximity_server/scene/certificate/certificate.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/proof/joint_box.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <string>
#include <vector>

namespace proximity_server::tools {

/// The robot and the objects that a certificate is about.
struct CertificateSubject {
  const scene::SceneModel& model;
  const scene::Objects* objects;  ///< nullptr: none
  std::string objects_text;       ///< the text of their file; "" without objects
};

/// The statement that pairs stay farther apart than a distance in a box of joint positions, with its evidence.
struct ApartCertificate {
  double contact_distance = 0.0;  ///< [m]
  scene::JointBox box;
  std::vector<scene::PairCertificate> pairs;
};

/// JSON with a line for each node of a tree; src/tools/prove/README.md describes it.
std::string certificateText(const ApartCertificate& certificate, const CertificateSubject& subject);

/// Reads such a text.
/// Failure: throws std::invalid_argument with the place in the text and the reason, also if the certificate is about
///          another robot or other objects, and for a bound that is not above the contact distance.
ApartCertificate readCertificate(const std::string& text, const CertificateSubject& subject);

/// The pair, as the tables of the tool name it.
std::string nameOf(const scene::ShapeRefPair& pair, const CertificateSubject& subject);

}  // namespace proximity_server::tools
