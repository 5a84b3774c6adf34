#pragma once

namespace proximity_server::scene {

/// Tells whether any pair of a state is at or below a distance.
struct StateVerdict {
  enum class Kind : unsigned char { Unknown, Above, Below };
  Kind kind = Kind::Unknown;

  /// For Below: the number of such a pair, see SceneBatch::pairs(). If there are several, it is the one that is found
  /// first; that depends on the state and the distance alone.
  int pair = -1;
};

}  // namespace proximity_server::scene
