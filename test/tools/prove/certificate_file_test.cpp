#include "tools/prove/certificate_file.h"

#include "proximity_server/scene/certificate/verify.h"
#include "proximity_server/scene/proof/certify.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "sanitized.h"
#include "scene/posed_scene.h"
#include "scene/proof/random_boxes.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace proximity_server::tools::certificate_file_test {

using namespace scene;

/// An arm beside a crate, with the certificates of its pairs about a bent state.
class CertificateFile : public ::testing::Test {
 protected:
  CertificateFile() {
    ProofQuestion question;
    question.objects = objects_;
    question.contact_distance = certificate_.contact_distance = 1e-3;
    for (const JointRange& range : jointRanges(model_->robot))
      certificate_.box.push_back({range.joint, range.joint == 0 ? -0.4 : 0.2, 0.8});
    const auto proofs = proveApart(model_, checkedPairs(*model_, objects_.get()), certificate_.box, question);
    for (const auto& pair : certify(model_, proofs, question))
      if (pair) certificate_.pairs.push_back(*pair);
    text_ = certificateText(certificate_, subject_);
  }

  void expectRefused(const std::string& text, const std::string& reason) const {
    try {
      readCertificate(text, subject_);
      ADD_FAILURE() << reason;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
    }
  }

  /// The text with the first occurrence of a part replaced.
  std::string with(const std::string& part, const std::string& other) const {
    const std::size_t at = text_.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    return std::string(text_).replace(at, part.size(), other);
  }

  const std::shared_ptr<const SceneModel> model_ = arm();
  const std::shared_ptr<const Objects> objects_ = std::make_shared<const Objects>(Objects(model_).changed(
      {AddObject{makeObject("crate", {{narrowphase::Box{{0.3, 0.3, 0.3}}}}, Fixed{at(-0.6, 0.0, 0.5)})}}));
  const CertificateSubject subject_{*model_, objects_.get(), "text of the crate"};
  ApartCertificate certificate_;
  std::string text_;
};

TEST_F(CertificateFile, IsReadAsItWasWritten) {
  const ApartCertificate read = readCertificate(text_, subject_);
  EXPECT_EQ(read.contact_distance, 1e-3);
  ASSERT_EQ(read.box.size(), certificate_.box.size());
  ASSERT_GT(read.pairs.size(), 5U);
  ASSERT_EQ(read.pairs.size(), certificate_.pairs.size());
  for (const PairCertificate& pair : read.pairs)
    EXPECT_EQ(flawIn(pair, read.box, *model_, objects_.get()), std::nullopt) << nameOf(pair.pair, subject_);
  EXPECT_EQ(certificateText(read, subject_), text_);
}

TEST_F(CertificateFile, AnotherRobotOrOtherObjectsAreRefusedByName) {
  SceneModel changed = *model_;
  changed.robot.joints[1].axis = -changed.robot.joints[1].axis;
  const auto refusal = [&](const CertificateSubject& subject) -> std::string {
    try {
      readCertificate(text_, subject);
      return "";
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  };
  EXPECT_EQ(refusal({changed, objects_.get(), "text of the crate"}).rfind("certificate.hashes.joints: is ", 0), 0U);
  changed = *model_;
  changed.robot.pieces[0].shape = changed.robot.pieces[0].shape.padded(1e-3);
  EXPECT_EQ(refusal({changed, objects_.get(), "text of the crate"}).rfind("certificate.hashes.shapes: is ", 0), 0U);
  changed = *model_;
  changed.pairs.pairs[0].padding = 1e-3;
  EXPECT_EQ(refusal({changed, objects_.get(), "text of the crate"}).rfind("certificate.hashes.pairs: is ", 0), 0U);
  EXPECT_EQ(refusal({*model_, nullptr, ""}).rfind("certificate.hashes.objects: is ", 0), 0U);
  EXPECT_EQ(refusal({*model_, objects_.get(), "another text"}).rfind("certificate.hashes.objects: is ", 0), 0U);
}

TEST_F(CertificateFile, BadTextIsRefusedAtItsPlace) {
  expectRefused("", "no JSON: ");
  expectRefused(text_.substr(0, text_.size() / 2), "no JSON: ");
  expectRefused("[]", "certificate: there is no \"format\"");
  expectRefused(with("\"format\": 1", "\"format\": 2"), "certificate.format: is not 1");
  expectRefused(with("\"contact_distance\": 0.001", "\"contact_distance\": -0.001"), "certificate.contact_distance: ");
  expectRefused(with("\"contact_distance\": 0.001", "\"contact_distance\": 10"),
                "certificate.pairs[0].bound: is not above the contact distance");
  expectRefused(with("\"box\": {", "\"box\": 3, \"boxes\": {"), "certificate.box: is no object");
  expectRefused(with("\"to_upper\":[", "\"to_uper\":["), "certificate.box: there is no movable joint \"to_uper\" (did");
  expectRefused(with("\"to_upper\":[", "\"to_upper\":[0,"), "certificate.box.to_upper: has not 2 elements");
  expectRefused(with("\"to_upper\":[", "\"to_upper\":[\"0\",0],\"to_fore\":["),
                "certificate.box.to_upper[0]: is no number");
  expectRefused(with("\"a\": \"base\"", "\"a\": \"bass\""), "certificate.pairs[0].a: there is no link \"bass\" (did");
  expectRefused(with("\"axes\"", "\"axis\""), "certificate.pairs[0].tree[0]: there is no \"axes\"");
  expectRefused(with("[[\"", "[[1,\""), "certificate.pairs[0].tree[0].axes[0]: has not 4 elements");
  expectRefused(with("\"tree\": [", "\"tree\": [{\"joint\": \"to_upper\"},"),
                "certificate.pairs[0].tree[0]: there is no \"at\"");
}

/// A byte that was changed makes the text unreadable, makes the evidence wrong, or leaves a statement that is true.
TEST_F(CertificateFile, AChangedByteNeverMakesAWrongStatement) {
  Chance chance(48);
  PosedScene scene(model_);
  scene.use(objects_);
  int unreadable = 0, wrong = 0, accepted = 0;
  for (int i = 0; i < repeats(2500); ++i) {
    std::string text = text_;
    text[static_cast<std::size_t>(chance.below(static_cast<int>(text.size())))] =
        chance.oneOf(std::string("0123456789-.,:e[]{}\"ax "));
    if (text == text_) continue;
    try {
      const ApartCertificate read = readCertificate(text, subject_);
      bool is_right = true;
      for (const PairCertificate& pair : read.pairs)
        is_right = is_right && !flawIn(pair, read.box, *model_, objects_.get());
      ++(is_right ? accepted : wrong);
      if (!is_right) continue;
      for (int s = 0; s < 3; ++s) {
        const Positions state = someStateIn(model_->robot, read.box, chance);
        for (const PairCertificate& pair : read.pairs)
          ASSERT_GE(distanceIn(scene, state, pair.pair), pair.bound - 1e-12) << text;
      }
    } catch (const std::invalid_argument&) {
      ++unreadable;
    }
  }
  if (kIsSanitized) return;
  EXPECT_GT(unreadable + wrong, 1000);
  EXPECT_GT(wrong, 50);
  EXPECT_GT(accepted, 50);
}

}  // namespace proximity_server::tools::certificate_file_test
