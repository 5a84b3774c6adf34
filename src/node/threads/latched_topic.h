#pragma once

namespace proximity_server::node {

/// Publishes `message` on a latched topic, so that also a subscriber that connects meanwhile gets it. roscpp latches a
/// message only after it has sent it to the subscribers that it knows: one that connects between has the message before,
/// or none, until the next one. If the number of subscribers has changed, the message is sent twice.
///
/// Limit: a subscriber that connects while another one leaves is not noticed.
template <class Topic, class Message>
void publishLatched(const Topic& topic, const Message& message) {
  const auto subscribers = topic.getNumSubscribers();
  topic.publish(message);
  if (topic.getNumSubscribers() != subscribers) topic.publish(message);
}

}  // namespace proximity_server::node
