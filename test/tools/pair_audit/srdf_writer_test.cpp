#include "tools/pair_audit/srdf_writer.h"

#include "scene/files.h"
#include "scene/small_robots.h"
#include "tools/robot/crossing_sliders.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::srdf_writer_test {

using namespace narrowphase;
using namespace scene;

class SrdfWriter : public ::testing::Test {
 protected:
  std::string written(const std::string& srdf) const { return writeSrdf(srdf, model_->robot, study_); }
  LinkPair pair(const std::string& srdf, const std::string& a, const std::string& b) const {
    const PairTable table = filterPairs(model_->robot, srdf);
    return table.pairs.at(table.find(model_->robot.findLink(a), model_->robot.findLink(b)));
  }

  const std::shared_ptr<const SceneModel>& model_ = crossingSlidersStudy().model;
  const PairStudy& study_ = crossingSlidersStudy().study;
};

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

TEST_F(SrdfWriter, ThePairFilterTakesWhatIsWritten) {
  for (const std::string& srdf : {written(""), written(kFaultySrdf)}) {
    EXPECT_EQ(pair(srdf, "base", "rod").detail, "Always");
    EXPECT_EQ(pair(srdf, "base", "far").detail, "Never");
    EXPECT_EQ(pair(srdf, "base", "cart").detail, "Adjacent");
    EXPECT_EQ(pair(srdf, "base", "tip").reason, PairReason::Checked);
    EXPECT_EQ(pair(srdf, "cart", "loose").reason, PairReason::Checked);
    EXPECT_TRUE(filterPairs(model_->robot, srdf).warnings.empty());
  }
}

// The tip comes to 0.36 of the rod, and the ball is from 0.75 to 2.75 behind its end.
TEST_F(SrdfWriter, DisablesNothingThatComesNearWithoutBeingAlwaysInContact) {
  for (const double distance : {0.4, 3.0}) {
    StudyOptions options;
    options.distance = distance;
    options.most_samples = 2000;
    const std::string srdf = writeSrdf("", model_->robot, studyPairs(model_, options));
    EXPECT_EQ(pair(srdf, "rod", "tip").reason, PairReason::Checked) << distance;
    EXPECT_EQ(pair(srdf, "rod", "far").reason == PairReason::Checked, distance == 3.0);
    EXPECT_EQ(pair(srdf, "base", "rod").detail, "Always") << distance;
    EXPECT_EQ(pair(srdf, "cart", "tip").detail, "Adjacent") << distance;
  }
}

TEST_F(SrdfWriter, KeepsAllElseInItsPlace) {
  const std::string srdf = written(kFaultySrdf);
  const auto comment = srdf.find("<!-- what moves -->"), group = srdf.find("<group name=\"all\">");
  const auto first = srdf.find("<disable_collisions"), state = srdf.find("<group_state name=\"home\"");
  ASSERT_TRUE(says(srdf, "<!-- what moves -->") && says(srdf, "<group_state name=\"home\""));
  EXPECT_LT(comment, group);
  EXPECT_LT(group, first);
  EXPECT_LT(first, state);
  EXPECT_FALSE(says(srdf, "User"));
}

TEST_F(SrdfWriter, WritingTwiceChangesNothing) {
  for (const std::string& srdf : {written(""), written(kFaultySrdf)}) EXPECT_EQ(written(srdf), srdf);
}

TEST_F(SrdfWriter, DoesNotDisableWhatIsEnabledByName) {
  const std::string srdf =
      written(R"(<robot name="crossing sliders"><enable_collisions link1="far" link2="base"/></robot>)");
  EXPECT_EQ(pair(srdf, "base", "far").reason, PairReason::Checked);
}

// The tip and the base come into contact, base and far never.
TEST_F(SrdfWriter, KeepsWhatAPersonHasDecided) {
  const std::string decided = "User: a bumper";
  const std::string entries = "<disable_collisions link1='tip' link2='base' reason='" + decided +
                              "'/><disable_collisions link1='far' link2='base' reason='" + decided + "'/>";
  const std::string srdf = written("<!-- licence --><?xml version='1.0'?><robot name='crossing sliders'>" + entries +
                                   "<disable_collisions link1='rod' link2='tip' reason='User'/></robot>");
  EXPECT_EQ(pair(srdf, "base", "tip").detail, decided);
  EXPECT_EQ(pair(srdf, "base", "far").detail, decided);
  EXPECT_EQ(pair(srdf, "rod", "tip").detail, "Never");
  EXPECT_TRUE(filterPairs(model_->robot, srdf).warnings.empty()) << srdf;
}

TEST_F(SrdfWriter, RefusesWhatIsNoSrdf) {
  EXPECT_TRUE(says(errorOf([&] { written("<robot"); }), "SRDF: "));
  EXPECT_EQ(errorOf([&] { written("<group/>"); }), "SRDF: no <robot> element");
}

// The ball comes to 0.75 of the rod.
TEST_F(SrdfWriter, NeverMeansBeyondTheWarnDistance) {
  StudyOptions options;
  options.most_samples = 2000;
  for (const double warn : {0.7, 0.8}) {
    options.warn_distance = warn;
    const std::string srdf = writeSrdf("", model_->robot, studyPairs(model_, options));
    EXPECT_EQ(pair(srdf, "rod", "far").reason == PairReason::Checked, warn == 0.8);
  }
}

TEST_F(SrdfWriter, NeverSaysWhereItIsNotProven) {
  PairStudy study = study_;
  for (PairEvidence& evidence : study.pairs) evidence.proven.reset();
  const std::string reason = pair(writeSrdf("", model_->robot, study), "base", "far").detail;
  EXPECT_EQ(reason.find("Never: not proven, closest seen 3.25"), 0U) << reason;
}

TEST_F(SrdfWriter, AddsDecisionsAtTheEnd) {
  EXPECT_EQ(withDisabled(kFaultySrdf, model_->robot, {}), kFaultySrdf);
  PairLevels levels;
  levels.pair = pairOf(*model_, "base", "rod");
  levels.collisions = 459;
  levels.at_rest = ClearanceLevel::Collision;
  const std::string entry = R"(<disable_collisions link1="base" link2="rod" )"
                            R"(reason="User: in contact at rest and in 91.8 % of random states"/>)";
  EXPECT_EQ(disablingEntry(model_->robot, levels), entry);
  const std::string srdf = withDisabled(kFaultySrdf, model_->robot, {levels});
  EXPECT_GT(srdf.find(entry), srdf.find("group_state")) << srdf;
  EXPECT_EQ(pair(srdf, "base", "rod").reason, PairReason::SrdfDisabled);
  EXPECT_EQ(pair(srdf, "rod", "tip").detail, "Never");
  EXPECT_TRUE(says(withDisabled("", model_->robot, {levels}), entry));
}

}  // namespace proximity_server::tools::srdf_writer_test
