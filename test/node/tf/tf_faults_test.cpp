#include "node/faults/tf_faults.h"

#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#include "node/answers.h"
#include "node/diagnosis.h"
#include "node/faults/child_process.h"
#include "node/gantry.h"

// The robot of gantry.urdf stands still with its ball 0.2 m from the base, and the way from it to tf is spoiled in
// every manner that tf_faults.h knows. The node runs with its defaults.

namespace proximity_server::node::tf_faults_test {

constexpr double kDistance = 0.2;   // [m] between base and ball
constexpr double kPeriod = 0.02;    // [s] of the monitor
constexpr double kMaxTfAge = 0.2;   // [s]
constexpr double kTfRate = 100.0;   // [Hz]
constexpr double kObserved = 0.35;  // [s] how long a fault lasts: longer than the node may take to notice

// What is promised.
constexpr double kBlindAfter = kMaxTfAge + 2.0 * kPeriod;  // [s] from the last good transform to INVALID
constexpr double kRecovery = 1.0;                          // [s] from the end of the fault to the right answer

std::vector<geometry_msgs::TransformStamped> stillGantry(const ros::Time& now) {
  std::vector<geometry_msgs::TransformStamped> transforms = Gantry::all({kDistance + 0.2, 0.0, 0.0});
  for (geometry_msgs::TransformStamped& transform : transforms) transform.header.stamp = now;
  return transforms;
}

bool isValid(const Clearance& message) { return message.level != Clearance::INVALID; }
bool isAt(const Clearance& message, double distance) {
  return isValid(message) && std::abs(message.minimum.distance - distance) <= kTolerance;
}

/// When the node ran this cycle, by its own clock: unlike the time of arrival, a busy machine does not shift it.
ros::Time timeOf(const Clearance& valid) { return valid.header.stamp + valid.tf_age; }

/// Whatever tf says, no number looks valid that is not.
void expectSound(const Clearance& message) {
  const Proximity& pair = message.minimum;
  if (!isValid(message)) {
    EXPECT_TRUE(saysNothing(pair));
    EXPECT_TRUE(message.below_threshold.empty());
    EXPECT_FALSE(message.status.message.empty());
    return;
  }
  EXPECT_LE(pair.lower_bound, pair.distance);
  EXPECT_LE(pair.distance, pair.upper_bound);
  EXPECT_NEAR(pair.normal.x * pair.normal.x + pair.normal.y * pair.normal.y + pair.normal.z * pair.normal.z, 1.0, 1e-9);
  EXPECT_LE(message.tf_age.toSec(), kMaxTfAge);
}

MinimumDistanceResponse askBaseAndBall() {
  MinimumDistanceRequest request;
  request.a = shape("base");
  request.b = shape("ball");
  return call<MinimumDistanceResponse>("/proximity_server/minimum_distance", request);
}

class OfTf : public testing::TestWithParam<TfFaultKind> {
 protected:
  static TfStream& tf() {
    static TfStream stream{ros::NodeHandle(), kTfRate, stillGantry};
    return stream;
  }

  void SetUp() override {
    tf();
    ASSERT_TRUE(next([](const Clearance& message) { return isAt(message, kDistance); }));
  }

  void TearDown() override {
    tf().apply(TfFault::None);
    const ros::Time healed = ros::Time::now();
    const auto recovered =
        next([&](const Clearance& message) { return isAt(message, kDistance) && message.header.stamp > healed; });
    ASSERT_TRUE(recovered) << "no recovery";
    EXPECT_LE(timeOf(*recovered), healed + ros::Duration(kRecovery));
  }

  ros::Time apply(TfFault fault, const std::string& child_frame) {
    tf().apply(fault, child_frame);
    return ros::Time::now();
  }

  /// The next sound message that `accept` likes.
  template <class Accept>
  std::optional<Clearance> next(Accept accept) {
    return inbox_.next([&](const Clearance& message) {
      expectSound(message);
      return accept(message);
    });
  }

  /// Every message of the next kObserved seconds, of which there is at least one.
  template <class Check>
  void watch(Check check) {
    const ros::Time end = ros::Time::now() + ros::Duration(kObserved);
    ASSERT_TRUE(next([&](const Clearance& message) {
      check(message);
      return ros::Time::now() >= end;
    }));
  }

  void expectBlindness(const ros::Time& since) {
    bool is_blind = false;
    watch([&](const Clearance& message) {
      is_blind = !isValid(message);
      if (is_blind) {
        EXPECT_NE(message.status.message.find("joint '"), std::string::npos) << message.status.message;
        return;
      }
      EXPECT_LE(timeOf(message), since + ros::Duration(kBlindAfter)) << "a stale level";
    });
    EXPECT_TRUE(is_blind) << "the fault goes unnoticed";
    const auto response = askBaseAndBall();
    EXPECT_FALSE(response.success);
    EXPECT_TRUE(saysNothing(response.pair));
  }

  Inbox<Clearance> inbox_{ros::NodeHandle(), "/proximity_server/clearance"};
};

std::string nameOf(const testing::TestParamInfo<TfFaultKind>& info) { return info.param.name; }

std::vector<TfFaultKind> faultsThat(TfEffect effect) {
  std::vector<TfFaultKind> faults;
  for (const TfFaultKind& kind : tfFaults()) {
    if (kind.effect == effect) faults.push_back(kind);
  }
  return faults;
}

// ---- what leaves nothing to be said about a joint

class BlindingFaultOfTf : public OfTf {};

TEST_P(BlindingFaultOfTf, OfOneFrameTurnsTheLevelInvalidInTime) { expectBlindness(apply(GetParam().fault, "slide")); }

INSTANTIATE_TEST_SUITE_P(Each, BlindingFaultOfTf, testing::ValuesIn(faultsThat(TfEffect::Blinds)), nameOf);

TEST_F(BlindingFaultOfTf, StampsAheadOfAllFramesTurnTheLevelInvalidInTime) {
  expectBlindness(apply(TfFault::StampsAhead, ""));
}

TEST_F(OfTf, TransformsThatAreTooOldAreToldByTheKindOfFault) {
  const std::pair<TfFault, std::string> kinds[] = {
      {TfFault::Silence, ": no message of frame 'slide' has come for 0."},
      {TfFault::FrozenStamp, ": messages of frame 'slide' come, but their stamp stands still at "},
      {TfFault::StampsOfThePast, ": messages of frame 'slide' come, but their stamps are 5"},
      {TfFault::NanPosition, ": messages of frame 'slide' come, but tf refuses their transforms"},
      {TfFault::NoStamp, ": messages of frame 'slide' come, but without a stamp"}};
  for (const auto& [fault, told] : kinds) {
    apply(fault, "slide");
    EXPECT_TRUE(next([&, text = told](const Clearance& message) {
      return message.status.code == QueryStatus::TF_STALE && message.status.message.find(text) != std::string::npos;
    })) << told;
  }
}

// ---- what changes nothing

class HarmlessFaultOfTf : public OfTf {};

TEST_P(HarmlessFaultOfTf, LeavesEveryAnswerRight) {
  apply(GetParam().fault, "slide");
  watch([](const Clearance& message) { EXPECT_TRUE(isAt(message, kDistance)) << message.status.message; });
}

INSTANTIATE_TEST_SUITE_P(Each, HarmlessFaultOfTf, testing::ValuesIn(faultsThat(TfEffect::None)), nameOf);

// ---- what tf says without a contradiction

TEST_F(OfTf, AJumpIsFollowedAtOnce) {
  const ros::Time jumped = apply(TfFault::Jump, "slide");
  const auto there = next([](const Clearance& message) {
    EXPECT_TRUE(isValid(message)) << message.status.message;
    return isAt(message, kDistance + kDisplacement);
  });
  ASSERT_TRUE(there);
  EXPECT_LE(timeOf(*there), jumped + ros::Duration(kBlindAfter));
  watch([](const Clearance& message) { EXPECT_TRUE(isAt(message, kDistance + kDisplacement)); });
}

TEST_F(OfTf, TwoPublishersThatDisagreeGiveNoDistanceThatNeitherOfThemLeadsTo) {
  apply(TfFault::TwoPublishers, "");
  watch([](const Clearance& message) {
    ASSERT_TRUE(isValid(message)) << message.status.message;
    EXPECT_GE(message.minimum.distance, kDistance - kTolerance);
  });
}

// ---- two publishers of one joint

using Status = diagnostic_msgs::DiagnosticStatus;

bool namesTwoPublishers(const Status& status) { return status.message.find("two publishers?") != std::string::npos; }

TEST_F(OfTf, TwoPublishersThatDisagreeAboutAJointAreAWarningThatNamesItUntilOneIsGone) {
  Diagnosis diagnosis("proximity_server: tf");
  apply(TfFault::TwoPublishers, "slide");
  const auto warning = diagnosis.next([](const Status& status) {
    const bool is_alone = status.message.find("more)") == std::string::npos;  // the test before let all joints jump
    return is_alone && status.message.rfind("joint 'x_axis': transforms jump by 0.5 m within ", 0) == 0;
  });
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->level, Status::WARN);
  apply(TfFault::None, "");
  EXPECT_TRUE(diagnosis.next([](const Status& status) { return status.level == Status::OK; }));
}

TEST_F(OfTf, TwoPublishersOfAFrameAreAWarningUntilOneIsGone) {
  Diagnosis diagnosis("proximity_server: tf");
  {
    ChildProcess rival({"rostopic", "pub", "--rate=20", "/tf", "tf2_msgs/TFMessage",
                        "{transforms: [{header: {frame_id: base}, child_frame_id: slide}]}", "__name:=rival"});
    EXPECT_TRUE(diagnosis.next([](const Status& status) {
      return status.level == Status::WARN && status.message.rfind("frame 'slide' has two publishers: '", 0) == 0 &&
             status.message.find("'/rival'") != std::string::npos;
    }));
  }
  EXPECT_TRUE(diagnosis.next([](const Status& status) { return status.level == Status::OK; }));
}

TEST_F(OfTf, OneJumpIsNoSecondPublisher) {
  Diagnosis diagnosis("proximity_server: tf");
  apply(TfFault::Jump, "slide");
  ASSERT_TRUE(next([](const Clearance& message) { return isAt(message, kDistance + kDisplacement); }));
  for (int n = 0; n < 4; ++n) {  // one a second, so that the jump back is another matter
    const auto status = diagnosis.next();
    ASSERT_TRUE(status);
    EXPECT_FALSE(namesTwoPublishers(*status)) << status->message;
  }
}

}  // namespace proximity_server::node::tf_faults_test
