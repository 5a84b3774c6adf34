#pragma once

#include <proximity_server/ApplyObjects.h>
#include "chance.h"
#include "node/soak/soak_record.h"
#include "proximity_server/scene/objects/objects.h"

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace proximity_server::node {

using namespace scene;

/// Changes the objects of the node all the time, and knows which of them it may have had when. They stand, are held by
/// a link, or move with the frame of one.
class SoakObjects {
 public:
  using Clock = std::chrono::steady_clock;
  using Set = std::shared_ptr<const Objects>;

  /// The record must outlive this. The base of the robot must be the reference frame of the node.
  SoakObjects(const std::shared_ptr<const SceneModel>& model, SoakRecord& record, unsigned seed);
  /// Ends when the record is stopped.
  ~SoakObjects() { thread_.join(); }

  /// The objects of a revision; nullptr if it is not known, as around a restart of the node.
  Set ofRevision(std::uint64_t revision) const;

  /// All that the node may have used for a call from `begin` until now; none if that is not known.
  std::vector<Set> since(Clock::time_point begin) const;

 private:
  struct Entry {
    std::uint64_t revision;
    Set objects;
    Clock::time_point from, until;  ///< the node may have used them
  };
  /// A change of the node, and the same of the scene.
  struct Change {
    proximity_server::ObjectChange asked;
    scene::ObjectChange same;
  };

  void run();
  bool beginAnew();
  void changeOnce();
  Change randomChange();
  bool apply(const proximity_server::ObjectChange& asked, ApplyObjectsResponse& response);
  void forget();

  const std::shared_ptr<const SceneModel> model_;
  const Set none_;
  SoakRecord& record_;
  Chance chance_;
  SoakCalls calls_;
  std::uint64_t node_start_ = 0;
  bool is_known_ = false;      ///< which objects the node has
  mutable std::mutex mutex_;   // guards the history
  std::deque<Entry> history_;  ///< the last one is that of now
  std::thread thread_;         // last: it uses all of the above
};

}  // namespace proximity_server::node
