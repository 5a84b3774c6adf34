#pragma once

#include "tools/clearance/clearance_question.h"
#include "tools/clearance/clearance_rows.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {

/// Collects what --report shows of the answers: the smallest distance of every pair and of every state or segment, and
/// the pairs that were never checked. clearance_report.py makes a page of it.
/// Frame: the frame of the root link. Metres, radians, seconds.
class ClearanceReport {
 public:
  static constexpr std::size_t kMoments = 5;  ///< the pairs whose closest state is shown with a picture

  /// The question must outlive this.
  ClearanceReport(const ClearanceQuestion& question, RowKind rows);

  /// Takes the answer about a state or segment.
  void add(const ClearanceAnswer& answer);

  /// Takes a sentence about states beyond limits; "" is none.
  void addExcess(const std::string& sentence);

  /// All facts, with the outlines of the pieces of the worst moments. Numbers that are not finite are null.
  nlohmann::ordered_json toJson() const;

 private:
  using Names = std::pair<std::string, std::string>;

  /// The first answer about a pair that has its smallest distance.
  struct PairRecord {
    ClearanceAnswer::OfPair closest;
    std::string row;                                          ///< as of --format json; "": there is no answer
    double lowest = std::numeric_limits<double>::infinity();  ///< [m] the lower bound for all states or segments
    std::shared_ptr<const scene::Objects> objects;
  };

  PairRecord& recordOf(const scene::ShapeRefPair& pair, const scene::Objects* objects);
  void take(const ClearanceAnswer::OfPair& of_pair, const ClearanceAnswer& answer);
  std::string rowOf(const ClearanceAnswer::OfPair& of_pair, const ClearanceAnswer& answer) const;
  void useObjects(const std::shared_ptr<const scene::Objects>& objects);
  double levelOf(const scene::PairProximity& pair) const;
  nlohmann::ordered_json momentOf(const PairRecord& record) const;
  nlohmann::ordered_json uncheckedPairs() const;

  const ClearanceQuestion& question_;
  const RowKind kind_;
  const StateRows rows_;
  std::map<Names, PairRecord> records_;
  std::vector<PairRecord*> of_links_;  ///< by StateRows::numberOf(); nullptr: there is none yet
  std::shared_ptr<const scene::Objects> objects_;
  std::map<Names, std::array<std::string, 2>> unchecked_;  ///< the reason and its detail
  std::vector<std::string> excess_;
  /// The curves over the states, or over the segments and their parts, by their names. A level is its number, -1 without an answer; contact is 1
  /// or 0, or NaN if it is not known.
  std::map<std::string, std::vector<double>> curves_;
};

}  // namespace proximity_server::tools
