#include "tools/clearance/clearance_report.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/numbers.h"
#include "tools/second_opinion/placed_pieces.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr int kDirections = 48;     // of an outline: a circle is drawn within 0.3 % of its radius
constexpr double kNoAnswer = -1.0;  // in place of a level
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// The outlines of a convex piece, seen along z, y and x.
Json outlinesOf(const PlacedPiece& placed) {
  const narrowphase::Shape& shape = placed.piece->shape;
  Json outlines = Json::array();
  for (const auto& [right, up] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    Json outline = Json::array();
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2.0 * 3.14159265358979323846 * i / kDirections;
      Vector3d direction = Vector3d::Zero();
      direction[right] = std::cos(angle);
      direction[up] = std::sin(angle);
      int vertex = 0;
      const Vector3d core =
          narrowphase::supportPoint(shape, placed.world_T_piece.linear().transpose() * direction, vertex);
      const Vector3d point = placed.world_T_piece * core + shape.margin() * direction;
      const Json corner{point[right], point[up]};
      if (outline.empty() || outline.back() != corner) outline.push_back(corner);
    }
    outlines.push_back(std::move(outline));
  }
  return outlines;
}

/// Each <collision>, and how exact its pieces are.
Json fidelityOf(const scene::RobotModel& robot) {
  Json rows = Json::array();
  for (const scene::Collision& collision : robot.collisions)
    rows.push_back({robot.links[collision.link].name, collision.description, toString(collision.representation),
                    collision.pieces.size(), collision.deviation, collision.uncovered});
  return rows;
}

Json settingsOf(const ClearanceQuestion& question) {
  double of_objects = 0.0;  // links have no padding here
  if (question.objects)
    for (const scene::Object& object : question.objects->all()) of_objects = std::max(of_objects, paddingOf(object));
  Json json{{"padding_of_objects", of_objects},
            {"is_uncertain", question.uncertainty.has_value()},
            {"has_tracking_error", !question.tracking_error.empty()},
            {"thresholds", Json()},
            {"contact_distance", question.motion.contact_distance}};
  if (question.thresholds) {
    const scene::LevelThresholds& thresholds = *question.thresholds;
    const scene::PairKind kind = question.objects ? scene::PairKind::Any : scene::PairKind::OfLinks;
    json["thresholds"] = {{"stop", thresholds.stop.links},
                          {"warn", thresholds.warn.links},
                          {"object_stop", thresholds.stop.objects},
                          {"object_warn", thresholds.warn.objects},
                          {"are_equal", thresholds.stop.areEqual(kind) && thresholds.warn.areEqual(kind)}};
  }
  return json;
}

}  // namespace

ClearanceReport::ClearanceReport(const ClearanceQuestion& question, RowKind rows)
    : question_(question), kind_(rows), rows_(question, RowFormat::Json), of_links_(question.pairs.size(), nullptr) {
  const std::vector<scene::Link>& links = question.model->robot.links;
  for (const scene::LinkPair& pair : question.model->pairs.pairs)
    if (pair.reason != scene::PairReason::Checked)
      unchecked_[{links[pair.link_a].name, links[pair.link_b].name}] = {toString(pair.reason), pair.detail};
}

ClearanceReport::PairRecord& ClearanceReport::recordOf(const scene::ShapeRefPair& pair, const scene::Objects* objects) {
  const int number = rows_.numberOf(pair);
  if (number >= 0 && of_links_[number]) return *of_links_[number];
  const scene::RobotModel& robot = question_.model->robot;
  PairRecord& record = records_[{nameOf(pair.a, robot, objects), nameOf(pair.b, robot, objects)}];
  if (number >= 0) of_links_[number] = &record;
  return record;
}

/// Takes the reasons of the pairs with objects. toJson() leaves out pairs that are checked in some state.
void ClearanceReport::useObjects(const std::shared_ptr<const scene::Objects>& objects) {
  if (!objects || objects == objects_) return;
  objects_ = objects;
  const scene::RobotModel& robot = question_.model->robot;
  for (const int number : objects->numbers()) {
    for (int link = 0; link < static_cast<int>(robot.links.size()); ++link) {
      const scene::PairReason reason = objects->reason(link, scene::ShapeRef::ofObject(number));
      if (reason == scene::PairReason::Checked || reason == scene::PairReason::NoGeometry) continue;
      unchecked_.insert({{robot.links[link].name, objects->object(number)->id}, {toString(reason), ""}});
    }
  }
}

void ClearanceReport::take(const ClearanceAnswer::OfPair& of_pair, const ClearanceAnswer& answer) {
  const narrowphase::SignedDistance& result = of_pair.pair.result;
  PairRecord& record = recordOf(of_pair.pair.asked, answer.objects.get());
  if (result.status == narrowphase::Status::Unknown) return;
  record.lowest = std::min(record.lowest, result.lower_bound);
  if (!record.row.empty() && !(result.distance < record.closest.pair.result.distance)) return;
  record = {of_pair, rowOf(of_pair, answer), record.lowest, answer.objects};
}

std::string ClearanceReport::rowOf(const ClearanceAnswer::OfPair& of_pair, const ClearanceAnswer& answer) const {
  if (kind_ == RowKind::Segment) {
    ClearanceAnswer alone{answer.number, answer.begin, answer.end, answer.objects, of_pair};
    alone.contact.t_free = answer.begin;
    if (question_.thresholds) alone.level = SegmentLevel{scene::levelOf(of_pair.pair, *question_.thresholds).level};
    return rowText(alone, question_, RowFormat::Json);
  }
  WrittenRows row;
  rows_.addPair(static_cast<std::uint64_t>(answer.number), of_pair.pair, of_pair.pair.result.lower_bound,
                answer.objects.get(), row);
  return row.bytes;
}

/// The number of the level, 0 without thresholds.
double ClearanceReport::levelOf(const scene::PairProximity& pair) const {
  if (pair.result.status == narrowphase::Status::Unknown) return kNoAnswer;
  return question_.thresholds ? static_cast<double>(scene::levelOf(pair, *question_.thresholds).level) : 0.0;
}

void ClearanceReport::add(const ClearanceAnswer& answer) {
  useObjects(answer.objects);
  double distance = kInfinity, lower = kInfinity, level = 0.0;
  for (const ClearanceAnswer::OfPair& of_pair : answer.of_pairs) {
    take(of_pair, answer);
    const double of_level = levelOf(of_pair.pair);
    level = std::min(of_level, level) < 0.0 ? kNoAnswer : std::max(level, of_level);
    distance = std::min(distance, of_pair.pair.result.distance);
    lower = std::min(lower, of_pair.pair.result.lower_bound);
  }
  if (kind_ == RowKind::State) {
    curves_["distance"].push_back(level < 0.0 ? kNoNumber : distance);
    curves_["lower"].push_back(level < 0.0 ? kNoNumber : lower);
    curves_["level"].push_back(level);
    return;
  }
  const auto append = [&](std::initializer_list<std::pair<const char*, double>> values) {
    for (const auto& [name, value] : values) curves_[name].push_back(value);
  };
  const scene::RobotTimeOfContact& contact = answer.contact;
  const double undecided = contact.status == narrowphase::Status::Converged ? 0.0 : kNoNumber;
  append({{"time", answer.closest.time},
          {"distance", answer.closest.pair.result.distance},
          {"contact", contact.contact ? 1.0 : undecided},
          {"t_contact", contact.t_contact}});
  for (const auto& [begin, end, lower_bound, of_part] : answer.parts)
    append({{"begin", begin},
            {"end", end},
            {"lower", lower_bound},
            {"level", of_part ? static_cast<double>(of_part->level) : kNoAnswer}});
}

void ClearanceReport::addExcess(const std::string& sentence) {
  if (!sentence.empty()) excess_.push_back(sentence);
}

/// The closest state of a pair, with its pieces and what it takes to see it again.
Json ClearanceReport::momentOf(const PairRecord& record) const {
  const scene::RobotModel& robot = question_.model->robot;
  const auto& [pair, status, time, positions] = record.closest;
  Json json{{"depth_is_lower_bound", pair.depth_is_lower_bound},
            {"positions", positionsJson(robot, positions)},
            {"shapes", Json::array()}};
  if (question_.thresholds) {
    json["stop"] = question_.thresholds->stop.of(pair.asked);
    json["warn"] = question_.thresholds->warn.of(pair.asked);
  }
  const scene::BodyPoses poses = scene::forwardKinematics(robot, positions);
  for (const scene::ShapeRef& ref : {pair.asked.a, pair.asked.b}) {
    Json shape = Json::array();
    for (const PlacedPiece& piece : placedPieces(ref, robot, record.objects.get(), poses).pieces)
      shape.push_back(outlinesOf(piece));
    json["shapes"].push_back(std::move(shape));
  }
  return json;
}

Json ClearanceReport::uncheckedPairs() const {
  Json pairs = Json::array();
  for (const auto& [names, reason] : unchecked_)
    if (records_.find(names) == records_.end()) pairs.push_back({names.first, names.second, reason[0], reason[1]});
  return pairs;
}

Json ClearanceReport::toJson() const {
  const scene::SceneModel& model = *question_.model;
  Json json{{"rows", kind_ == RowKind::State ? "state" : "segment"},
            {"curves", curves_},
            {"settings", settingsOf(question_)},
            {"collisions", fidelityOf(model.robot)},
            {"warnings", model.robot.warnings},
            {"pairs", Json::array()},
            {"moments", Json::array()},
            {"unchecked", uncheckedPairs()},
            {"excess", excess_}};
  for (const std::string& warning : model.pairs.warnings) json["warnings"].push_back(warning);
  // The worst level first, then the smallest distance; pairs without an answer last.
  std::vector<std::tuple<bool, double, double, const Names*, const PairRecord*>> sorted;
  for (const auto& [names, record] : records_)
    sorted.emplace_back(record.row.empty(), -levelOf(record.closest.pair), record.closest.pair.result.distance, &names,
                        &record);
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return std::tie(std::get<0>(a), std::get<1>(a), std::get<2>(a)) <
           std::tie(std::get<0>(b), std::get<1>(b), std::get<2>(b));
  });
  for (const auto& [is_unknown, level, distance, names, record] : sorted) {
    Json pair = is_unknown ? Json{{"link_a", names->first}, {"link_b", names->second}, {"distance", Json()}}
                           : Json::parse(record->row);
    pair.update({{"lowest", record->lowest}, {"time", record->closest.time}});
    json["pairs"].push_back(std::move(pair));
    if (!is_unknown && json["moments"].size() < kMoments) json["moments"].push_back(momentOf(*record));
  }
  return json;
}

}  // namespace proximity_server::tools
