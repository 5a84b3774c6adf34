#pragma once

namespace proximity_server::scene {

/// Whether some candidate pair of a state is at or below a distance.
struct StateVerdict {
  enum class Kind : unsigned char { Unknown, Above, Below };
  Kind kind = Kind::Unknown;

  /// Of Below: such a pair, a number among the candidates; of several, that which is found first. It is a function of the state
  /// and the distance alone.
  int pair = -1;
};

}  // namespace proximity_server::scene
