#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "system/whole_file.h"
#include "tools/second_opinion/judgement.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

class ProgramOptions;

/// The options of the second opinion.
struct SecondOpinionOptions {
  bool is_wanted = false;
  double tolerance = 1e-5;  ///< [m]
  std::string out;          ///< "": no list
};

/// Declares --second-opinion, --second-opinion-tolerance and --second-opinion-out. The first is an error where this
/// build has no FCL.
void declareSecondOpinion(ProgramOptions& program, SecondOpinionOptions& options);

/// Asks another library about the pairs that are listed, and judges where it differs from ours.
///
/// Pairs are asked in blocks, each in a child process of its own, because FCL may throw, abort or never end. The pairs
/// that differ become rows of the list (CSV).
class SecondOpinion {
 public:
  /// Failure: throws std::invalid_argument if the list cannot be written.
  SecondOpinion(const SecondOpinionOptions& options, std::shared_ptr<const scene::SceneModel> model);

  /// Takes the pairs that were listed of a state; `objects` is nullptr if there are none.
  void add(long state, const std::vector<scene::PairProximity>& pairs, const scene::Positions& positions,
           std::shared_ptr<const scene::Objects> objects);

  /// Asks about what is left. Throws std::invalid_argument if writing the list failed.
  void end();

  /// Gives the list its name, after end().
  void complete();

  /// One line for people, and a second one with the worst difference, if there is one. After end().
  std::string summary() const;

  /// Whether some answer of ours contradicts what is proven.
  bool refutesOurs() const { return countOf(Ruling::OursRefuted) > 0; }

  long countOf(Ruling ruling) const { return counts_[static_cast<std::size_t>(ruling)]; }

 private:
  struct PendingState {
    long number;
    std::vector<scene::PairProximity> pairs;
    scene::BodyPoses poses;
    std::shared_ptr<const scene::Objects> objects;
  };
  struct PendingPair {
    const PendingState& state;
    const scene::PairProximity& pair;
  };
  std::vector<PendingPair> pendingPairs() const;
  void askBlock();
  void judgePair(const PendingPair& pending, const OtherOpinion& other);
  PlacedPieces piecesOf(const scene::ShapeRef& ref, const PendingState& state) const;
  double paddingOf(const scene::ShapeRefPair& pair) const;
  std::string rowOf(const PendingPair& pending, const OtherOpinion& other, const Judgement& judgement) const;
  std::string sentenceOf(const PendingPair& pending, const OtherOpinion& other, const Judgement& judgement) const;

  SecondOpinionOptions options_;
  std::shared_ptr<const scene::SceneModel> model_;
  std::optional<system::WholeFile> list_;
  std::vector<PendingState> block_;
  std::size_t pairs_in_block_ = 0;
  std::array<long, 8> counts_{};  ///< by ruling
  double worst_difference_ = 0.0;
  std::string worst_;
};

}  // namespace proximity_server::tools
