// The executable from end to end, on robots whose distances paper knows.
#include "robots/urdf.h"
#include "tools/program/run_command.h"
#include "tools/robot/two_sliders.h"
#include "tools/text/csv.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <sstream>
#include <string>

namespace proximity_server::tools::prove_test {

using Json = nlohmann::json;

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

class Prove : public ::testing::Test {
 protected:
  CommandResult run(const std::string& arguments) const {
    return runCommandApart(PROVE " " + urdf_ + " --quiet " + arguments);
  }
  Json json(const std::string& arguments) const { return Json::parse(run(arguments + " --format json").output); }

  void expectRefused(const std::string& arguments, const std::string& reason) const {
    const CommandResult result = run(arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_EQ(result.output, "") << arguments;
    EXPECT_TRUE(says(result.errors, reason)) << result.errors;
  }

  TemporaryFiles files_;
  std::string urdf_ = files_.write("robot.urdf", kTwoSliders);
};

// The sled touches the base at slide = -1. From there it is 1 + slide away, and the ball 2.25 + slide from the sled.
TEST_F(Prove, TheLimitsOfTheUrdfAreTheBox) {
  const CommandResult result = run("--pairs all");
  EXPECT_EQ(result.exit_code, 2) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_TRUE(says(result.output,
                   "Robot \"two sliders\": 5 pairs, in contact up to 1e-06 m.\n  slide from -1 to 2\n"
                   "The model is the geometry of the URDF.\n"))
      << result.output;
  EXPECT_TRUE(says(result.output, "\nproven (4)\n")) << result.output;
  EXPECT_TRUE(says(result.output, "\nrefuted (1)\n  base - sled, left: in contact, at slide=-1\n")) << result.output;
  EXPECT_TRUE(says(result.output, "\nundecided (0)\n")) << result.output;
  EXPECT_TRUE(says(result.output, "\n\nrefuted: 1 of 5 pairs come into contact\n")) << result.output;
}

TEST_F(Prove, ABoxInWhichAllStayApartEndsWithZero) {
  const CommandResult result = run("--pairs all --box " + files_.write("box.yaml", "slide: [-0.9, 1]"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(says(result.output, "  slide from -0.9 to 1\n")) << result.output;
  EXPECT_TRUE(says(result.output, "proven: no pair comes into contact in the box\n")) << result.output;
}

TEST_F(Prove, JsonHasTheSameWithAllDigits) {
  const std::string box = files_.write("box.yaml", "slide: [0.5, 1]");
  const Json answer = json("--pairs all --clearance 2.8 --box " + box);
  EXPECT_EQ(answer["contact_distance"], 2.8);
  EXPECT_EQ(answer["box"]["slide"], Json({0.5, 1.0}));
  EXPECT_EQ(answer["pairs"].size(), 5U);
  int refuted = 0;
  for (const Json& pair : answer["pairs"]) {
    if (pair["a"] != "ball" || pair["b"] != "sled, left") continue;
    ++refuted;
    EXPECT_EQ(pair["outcome"], "refuted") << "2.75 at 0.5";
    const double slide = pair["closest"]["slide"];
    EXPECT_GE(slide, 0.5);
    EXPECT_LE(slide, 0.55 + 1e-9);
    EXPECT_NEAR(pair["closest_upper_bound"], 2.25 + slide, 1e-9);
    EXPECT_LE(pair["lower_bound"], 2.75);
  }
  EXPECT_EQ(refuted, 1);
}

TEST_F(Prove, AboutAStateTheBoxHasItsRadius) {
  const Json answer = json("--about slide=-0.5 --radius 0.75");
  EXPECT_EQ(answer["box"]["slide"], Json({-1.0, 0.25}));
}

TEST_F(Prove, TheLargestBoxEndsBeforeContact) {
  const std::string arguments = "--pairs all --about slide=0 --radius 1.5 --largest";
  const CommandResult result = run(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(says(result.output, "\nThe box reaches 0.99")) << result.output;
  EXPECT_TRUE(says(result.output, " rad or m from the state.\n  beyond, refuted: base - sled, left: "))
      << result.output;
  const Json answer = json(arguments);
  EXPECT_LT(answer["reach"], 1.0);
  EXPECT_EQ(answer["box"]["slide"][1], answer["reach"]);
  EXPECT_EQ(answer["beyond"].size(), 1U);
  EXPECT_EQ(run("--pairs all --about slide=-1 --radius 1 --largest").exit_code, 2);
}

TEST_F(Prove, OnlyNamedLinksCount) {
  EXPECT_EQ(json("--pairs all --only ball")["pairs"].size(), 3U);
  EXPECT_EQ(json("--pairs all --only ball --only base")["pairs"].size(), 1U);
}

TEST_F(Prove, SharesTellHowMuchIsInContact) {
  // The sled is nearer than 0.5 to the base in a sixth of its range.
  const Json pair =
      json("--pairs all --only base --only 'sled, left' --clearance 0.5 --shares --boxes 1000")["pairs"][0];
  const double in_contact = pair["in_contact"], undecided = pair["undecided"];
  EXPECT_LE(in_contact, 1.0 / 6.0);
  EXPECT_GE(in_contact + undecided, 1.0 / 6.0);
  EXPECT_LT(undecided, 0.01);
}

TEST_F(Prove, ClearanceFindsTheRefutingStatesInContact) {
  const std::string states = files_.path("states.csv");
  EXPECT_EQ(run("--pairs all --clearance 0.1 --refuting " + states).exit_code, 2);
  const CommandResult result =
      runCommandApart(CLEARANCE " " + urdf_ + " --quiet --no-filter --format json --states " + states);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_LE(Json::parse(result.output)[0]["distance"], 0.1 + 1e-9);
}

TEST_F(Prove, WhatALinkHoldsMovesWithIt) {
  // The frame of the sled is at 2 + slide; the sphere reaches back to 0.9 + slide, and the base to 0.5.
  const std::string objects = files_.write("objects.yaml",
                                           "- {id: bar, link: \"sled, left\", pose: {position: [-1, 0, 0]}, "
                                           "primitives: [{type: SPHERE, dimensions: [0.1]}]}");
  const std::string arguments = "--only bar --only base --objects " + objects + " --box ";
  const CommandResult proven = run(arguments + files_.write("apart.yaml", "slide: [-0.399, 2]"));
  EXPECT_EQ(proven.exit_code, 0) << proven.errors;
  EXPECT_TRUE(says(proven.output, "\nproven (1)\n  base - bar: at least ")) << proven.output;
  const CommandResult refuted = run(arguments + files_.write("meeting.yaml", "slide: [-0.401, 2]"));
  EXPECT_EQ(refuted.exit_code, 2) << refuted.errors;
  EXPECT_TRUE(says(refuted.output, "\nrefuted (1)\n  base - bar: in contact, at slide=-0.40")) << refuted.output;
}

TEST_F(Prove, TightBoundsAreNearToTheSmallestDistance) {
  const Json pair = json("--pairs all --only ball --only 'sled, left' --tightness 0.9")["pairs"][0];
  EXPECT_LE(pair["lower_bound"], 1.25);
  EXPECT_GE(pair["lower_bound"], 0.9 * 1.25);
}

TEST_F(Prove, WhatABudgetLeavesIsUndecided) {
  const CommandResult result = run("--pairs all --clearance 4.2 --only ball --only mast --boxes 1");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(says(result.output, "\nundecided (1)\n  ball - mast: 100 % of the box is left, no nearer than "))
      << result.output;
  EXPECT_TRUE(says(result.output, "\nundecided: 1 of 1 pairs; more: --boxes, --time-budget\n")) << result.output;
}

TEST_F(Prove, TheCertificateOfAProofVerifies) {
  const std::string certificate = files_.path("certificate.json");
  const std::string box = files_.write("box.yaml", "slide: [-0.9, 1]");
  EXPECT_EQ(run("--pairs all --box " + box + " --certificate " + certificate).exit_code, 0);
  const CommandResult result = run("--check " + certificate);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(says(result.output,
                   "Robot \"two sliders\": 5 pairs with a certificate, in contact up to 1e-06 m.\n"
                   "  slide from -0.9 to 1\n\nverified (5)\n"))
      << result.output;
  EXPECT_TRUE(says(result.output, "\nnot verified (0)\n")) << result.output;
  EXPECT_TRUE(says(result.output, "\nverified: no pair of the certificate comes into contact in the box\n"));
}

TEST_F(Prove, OnlyProvenPairsAreInTheCertificate) {
  const std::string certificate = files_.path("certificate.json");
  EXPECT_EQ(run("--pairs all --certificate " + certificate).exit_code, 2) << "base and sled come into contact";
  const CommandResult result = run("--check " + certificate);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(says(result.output, "\nverified (4)\n")) << result.output;
  EXPECT_FALSE(says(result.output, "base - sled")) << result.output;
}

// Regression: it was "verified".
TEST_F(Prove, ACertificateWithoutPairsVerifiesNothing) {
  const std::string certificate = files_.path("certificate.json");
  EXPECT_EQ(run("--only base --only 'sled, left' --pairs all --certificate " + certificate).exit_code, 2);
  for (const std::string format : {"text", "json"}) {
    const CommandResult result = run("--check " + certificate + " --format " + format);
    EXPECT_EQ(result.exit_code, 2) << result.errors;
    EXPECT_EQ(says(result.output, "\nnothing is verified: the certificate has no pair\n"), format == "text");
    EXPECT_FALSE(says(result.output, "\nverified: ")) << result.output;
  }
}

TEST_F(Prove, AWrongCertificateIsRefusedWithItsPair) {
  const std::string path = files_.path("certificate.json");
  EXPECT_EQ(run("--only base --only ball --pairs all --certificate " + path).exit_code, 0);
  Json certificate = Json::parse(std::ifstream(path));
  certificate["pairs"][0]["bound"] = 2.26;  // the ball is 4.25 + 2 slide from the base, and slide from -1
  const CommandResult result = run("--check " + files_.write("wrong.json", certificate.dump()));
  EXPECT_EQ(result.exit_code, 2) << result.errors;
  EXPECT_TRUE(
      says(result.output, "\nnot verified (1)\n  base - ball: node 1, where slide=-1..2: its axes prove 2.2499"))
      << result.output;
  EXPECT_TRUE(says(result.output, "\nthe certificate is wrong\n")) << result.output;
}

TEST_F(Prove, ACheckIsReportedAsJson) {
  const std::string path = files_.path("certificate.json");
  const std::string box = files_.write("box.yaml", "slide: [-0.9, 1]");
  EXPECT_EQ(run("--pairs all --only ball --box " + box + " --certificate " + path).exit_code, 0);
  const Json verified = json("--check " + path);
  EXPECT_EQ(verified["robot"], "two sliders");
  EXPECT_EQ(verified["box"], Json::parse(R"({"slide": [-0.9, 1.0]})"));
  EXPECT_EQ(verified["verified"], 3);
  EXPECT_EQ(verified["wrong"], 0);
  EXPECT_EQ(verified["without_certificate"], 1) << "of the two without the ball one is a joint's";
  Json certificate = Json::parse(std::ifstream(path));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(verified["pairs"][i]["bound"], certificate["pairs"][i]["bound"]);
    EXPECT_TRUE(verified["pairs"][i]["flaw"].is_null());
  }
  certificate["pairs"][1]["bound"] = 100.0;
  const Json wrong = json("--check " + files_.write("wrong.json", certificate.dump()));
  EXPECT_EQ(wrong["wrong"], 1);
  EXPECT_TRUE(says(wrong["pairs"][1]["flaw"].get<std::string>(), "its axes prove"));
}

TEST_F(Prove, ACertificateOfAnotherRobotIsRefused) {
  const std::string certificate = files_.path("certificate.json");
  EXPECT_EQ(run("--pairs all --only mast --certificate " + certificate).exit_code, 0);
  std::string other = kTwoSliders;
  urdf_ = files_.write("other.urdf", other.replace(other.find("xyz=\"5 0 0\""), 11, "xyz=\"6 0 0\""));
  expectRefused("--check " + certificate, "certificate.json: certificate.hashes.joints: is ");
}

TEST_F(Prove, JointsWithoutLimitsNeedAnInterval) {
  using namespace robots;
  urdf_ = files_.write("endless.urdf",
                       urdfOf(link("base", ball("0.1")) + link("turn") + link("half", ball("0.1", "1 0 0")) +
                              hinge("leader", "base", "turn", "0 0 1") +
                              joint("follower", "continuous", "turn", "half", axis("0 0 1") + mimic("leader", "0.5"))));
  expectRefused("", "joint \"leader\", between base - half, has no interval");
  EXPECT_EQ(run("--box " + files_.write("box.yaml", "leader: [-6.3, 6.3]")).exit_code, 0);
}

}  // namespace proximity_server::tools::prove_test
