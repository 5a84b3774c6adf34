#include "node/threads/latched_topic.h"

#include <gtest/gtest.h>

#include <optional>

namespace proximity_server::node {
namespace {

/// A latched topic of roscpp while a subscriber connects between sending a message and latching it.
struct Topic {
  int getNumSubscribers() const { return received ? 1 : 0; }
  void publish(int message) const {
    if (received) *received = message;
    if (connects && !received) received = latched;
    latched = message;
  }

  bool connects;
  mutable int latched = 0;
  mutable std::optional<int> received;
};

TEST(LatchedTopic, ReachesASubscriberThatConnectsWhileItIsPublished) {
  const Topic topic{/*connects=*/true, 0, {}};
  publishLatched(topic, 7);
  EXPECT_EQ(topic.received, 7);
}

TEST(LatchedTopic, LatchesForThoseThatConnectLater) {
  const Topic topic{/*connects=*/false, 0, {}};
  publishLatched(topic, 7);
  EXPECT_EQ(topic.latched, 7);
}

}  // namespace
}  // namespace proximity_server::node
