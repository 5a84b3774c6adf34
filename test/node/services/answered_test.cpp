// Exceptions within a service become answers with their text.
#include "node/services/answered.h"

#include "proximity_server/FirstContact.h"
#include "proximity_server/MinimumDistance.h"
#include "proximity_server/PenetrationDepth.h"
#include "proximity_server/ProveJointBox.h"
#include "proximity_server/QueryConfiguration.h"
#include "proximity_server/QueryPairs.h"
#include "proximity_server/QueryPoints.h"
#include "proximity_server/QueryRays.h"
#include "proximity_server/QueryTrajectory.h"
#include "proximity_server/SeparationAxis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>

namespace proximity_server::node::answered_test {

MinimumDistanceResponse withoutNumbers() {
  MinimumDistanceResponse response;
  response.pair.distance = std::numeric_limits<double>::quiet_NaN();
  return response;
}

/// The answer of a service that knows its header and half of its result when it throws.
template <class Exception>
MinimumDistanceResponse answerThatThrows(const Exception& exception) {
  return answered(withoutNumbers(), [&](MinimumDistanceResponse& response) {
    response.header.frame_id = "base";
    response.pair.distance = 0.25;
    throw exception;
  });
}

void expectInternalError(const MinimumDistanceResponse& response, const std::string& text) {
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.status.code, QueryStatus::INTERNAL_ERROR);
  EXPECT_NE(response.status.message.find(text), std::string::npos) << response.status.message;
  EXPECT_EQ(response.header.frame_id, "base");
  EXPECT_TRUE(std::isnan(response.pair.distance)) << "a number of a failed answer looks valid";
}

TEST(Answered, KeepsCodeAndTextOfARequestError) {
  const MinimumDistanceResponse response = answerThatThrows(RequestError(QueryStatus::UNKNOWN_LINK, "no link 'x'"));
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.status.code, QueryStatus::UNKNOWN_LINK);
  EXPECT_EQ(response.status.message, "no link 'x'");
  EXPECT_TRUE(std::isnan(response.pair.distance));
}

// Regression: exceptions other than RequestError left the service, and the client learned only that its call failed.
TEST(Answered, TurnsAnExceptionIntoAnInternalErrorWithItsText) {
  expectInternalError(answerThatThrows(std::runtime_error("the sky fell")), "the sky fell");
}

TEST(Answered, TurnsALackOfMemoryIntoAnInternalErrorWithItsText) {
  expectInternalError(answerThatThrows(std::bad_alloc()), std::bad_alloc().what());
}

TEST(Answered, TurnsAnythingElseThatIsThrownIntoAnInternalError) {
  expectInternalError(answerThatThrows(42), "exception of unknown type");
}

TEST(Answered, SucceedsWithTheStatusOk) {
  const auto response = answered(withoutNumbers(), [](MinimumDistanceResponse& r) { r.pair.distance = 0.25; });
  EXPECT_TRUE(response.success);
  EXPECT_EQ(response.pair.distance, 0.25);
}

template <class Response>
class AnsweredByEveryService : public testing::Test {};
using Responses = testing::Types<MinimumDistanceResponse, SeparationAxisResponse, PenetrationDepthResponse,
                                 QueryPairsResponse, QueryPointsResponse, QueryRaysResponse, QueryConfigurationResponse,
                                 FirstContactResponse, QueryTrajectoryResponse, ProveJointBoxResponse>;
TYPED_TEST_SUITE(AnsweredByEveryService, Responses);

TYPED_TEST(AnsweredByEveryService, AnExceptionBecomesAFailedAnswerWithItsText) {
  const TypeParam response =
      answered(TypeParam(), [](TypeParam&) { throw std::logic_error("a vertex without a face"); });
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.status.code, QueryStatus::INTERNAL_ERROR);
  EXPECT_NE(response.status.message.find("a vertex without a face"), std::string::npos) << response.status.message;
}

}  // namespace proximity_server::node::answered_test
