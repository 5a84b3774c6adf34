#include "tools/clearance/clearance_report.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/scene/model/kinematics.h"
#include "tools/second_opinion/placed_pieces.h"
#include "tools/states/joint_columns.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr int kDirections = 48;     // of an outline: a circle is drawn within 0.3 % of its radius
constexpr double kNoAnswer = -1.0;  // in place of a level
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

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

Json toJson(const Vector3d& point) { return {point.x(), point.y(), point.z()}; }

/// The links with geometry, and how exact their pieces are.
Json fidelityOf(const scene::RobotModel& robot) {
  Json links = Json::array();
  for (const scene::Link& link : robot.links) {
    if (link.collisions.empty()) continue;
    Json collisions = Json::array();
    for (const int number : link.collisions) {
      const scene::Collision& collision = robot.collisions[number];
      collisions.push_back({{"geometry", collision.description},
                            {"representation", toString(collision.representation)},
                            {"pieces", collision.pieces.size()},
                            {"deviation", collision.deviation},
                            {"uncovered", collision.uncovered}});
    }
    links.push_back({{"link", link.name}, {"collisions", std::move(collisions)}});
  }
  return links;
}

Json settingsOf(const ClearanceQuestion& question) {
  double padding = 0.0, of_objects = 0.0;
  for (const scene::LinkPair& pair : question.model->pairs.pairs) padding = std::max(padding, pair.padding);
  if (question.objects)
    for (const scene::Object& object : question.objects->all()) of_objects = std::max(of_objects, paddingOf(object));
  Json json{{"padding", padding},
            {"padding_of_objects", of_objects},
            {"is_uncertain", question.uncertainty.has_value()},
            {"has_tracking_error", !question.tracking_error.empty()},
            {"thresholds", Json()},
            {"contact_distance", question.motion.contact_distance}};
  if (question.thresholds) {
    const scene::LevelThresholds& thresholds = *question.thresholds;
    json["thresholds"] = {{"stop", thresholds.stop.links},
                          {"warn", thresholds.warn.links},
                          {"object_stop", thresholds.stop.objects},
                          {"object_warn", thresholds.warn.objects}};
  }
  return json;
}

}  // namespace

ClearanceReport::ClearanceReport(const ClearanceQuestion& question, RowKind rows)
    : question_(question),
      rows_(rows),
      numbers_(question.pairs, question.model->robot.links.size()),
      of_links_(question.pairs.size(), nullptr) {
  const scene::SceneModel& model = *question.model;
  for (const scene::LinkPair& pair : model.pairs.pairs)
    if (pair.reason != scene::PairReason::Checked)
      unchecked_[{model.robot.links[pair.link_a].name, model.robot.links[pair.link_b].name}] = {toString(pair.reason),
                                                                                                pair.detail};
}

ClearanceReport::PairRecord& ClearanceReport::recordOf(const scene::ShapeRefPair& pair, const scene::Objects* objects) {
  const int number = numbers_.of(pair);
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
    const auto object = scene::ShapeRef::ofObject(number);
    for (int link = 0; link < static_cast<int>(robot.links.size()); ++link) {
      const scene::PairReason reason = objects->reason(link, object);
      if (reason == scene::PairReason::Checked || reason == scene::PairReason::NoGeometry) continue;
      unchecked_.insert({{robot.links[link].name, objects->object(number)->id}, {toString(reason), ""}});
    }
  }
}

ClearanceReport::Beyond ClearanceReport::beyondLimits(const scene::Positions& positions) const {
  Beyond beyond;
  const std::vector<scene::Joint>& joints = question_.model->robot.joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].mimic || !hasOnePosition(joints[i])) continue;
    if (positions[i] < joints[i].lower - kLimitRounding || positions[i] > joints[i].upper + kLimitRounding)
      beyond.emplace(static_cast<int>(i), positions[i]);
  }
  return beyond;
}

void ClearanceReport::countExcess(long number, const Beyond& beyond) {
  if (!beyond.empty()) ++states_beyond_;
  for (const auto& [joint, position] : beyond) {
    Excess& excess = beyond_[joint];
    if (excess.states++ > 0) continue;
    excess.first = number;
    excess.position = position;
  }
}

/// Returns the level of the pair as a number, -1 without an answer.
double ClearanceReport::take(const scene::PairProximity& pair, const Moment& moment) {
  PairRecord& record = recordOf(pair.asked, moment.objects.get());
  if (pair.result.status == narrowphase::Status::Unknown) return kNoAnswer;
  record.lower = std::min(record.lower, pair.result.lower_bound);
  if (record.number < 0 || pair.result.distance < record.closest.result.distance) {
    record.closest = pair;
    record.number = moment.number;
    record.time = moment.time;
    record.positions = moment.positions;
    record.objects = moment.objects;
  }
  if (!question_.thresholds) return 0.0;
  const scene::ClearanceLevel level = levelOf(pair, *question_.thresholds).level;
  record.level = std::max(record.level, level);
  return static_cast<double>(level);
}

void ClearanceReport::add(const StateClearance& answer) {
  useObjects(answer.objects);
  countExcess(answer.state, beyondLimits(answer.positions));
  double distance = kInfinity, lower = kInfinity, level = 0.0;
  for (const scene::PairProximity& pair : answer.all_pairs) {
    const double of_pair = take(pair, {answer.state, answer.time, answer.positions, answer.objects});
    level = of_pair < 0.0 || level < 0.0 ? kNoAnswer : std::max(level, of_pair);
    if (of_pair < 0.0) continue;
    distance = std::min(distance, pair.result.distance);
    lower = std::min(lower, pair.result.lower_bound);
  }
  curves_["distance"].push_back(level < 0.0 ? kUnknown : distance);
  curves_["lower"].push_back(level < 0.0 ? kUnknown : lower);
  curves_["level"].push_back(level);
}

void ClearanceReport::add(const SegmentClearance& answer) {
  const TrajectorySegment& segment = answer.segment;
  useObjects(segment.objects);
  Beyond beyond = beyondLimits(segment.from);
  beyond.merge(beyondLimits(segment.to));
  if (segment.spline)
    for (const auto& excess : segment.spline->beyondLimits(question_.model->robot))
      beyond.emplace(excess.joint, excess.position);
  countExcess(segment.number, beyond);
  for (const scene::SplineMinimum& minimum : answer.of_pairs) {
    scene::PairProximity pair = minimum.pair;
    pair.result.lower_bound = minimum.lower_bound;
    pair.result.upper_bound = minimum.upper_bound;
    take(pair, {segment.number, segment.timeAt(minimum.time), minimum.state, segment.objects});
  }
  const scene::RobotTimeOfContact& contact = answer.contact;
  const double undecided = contact.status == narrowphase::Status::Converged ? 0.0 : kUnknown;
  for (const auto& [name, value] : {std::pair{"begin", segment.begin},
                                    {"end", segment.end},
                                    {"time", segment.timeAt(answer.minimum.time)},
                                    {"distance", answer.minimum.pair.result.distance},
                                    {"lower", answer.minimum.lower_bound},
                                    {"upper", answer.minimum.upper_bound},
                                    {"contact", contact.contact ? 1.0 : undecided},
                                    {"t_contact", segment.timeAt(contact.t_contact)}})
    curves_[name].push_back(value);
}

/// The worst level first, then the smallest distance; pairs without an answer last.
std::vector<const ClearanceReport::NamedRecord*> ClearanceReport::sortedRecords() const {
  std::vector<const NamedRecord*> sorted;
  for (const NamedRecord& named : records_) sorted.push_back(&named);
  const auto place = [](const NamedRecord* named) {
    const PairRecord& record = named->second;
    return std::tuple(record.number < 0, -static_cast<int>(record.level), record.closest.result.distance);
  };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const NamedRecord* a, const NamedRecord* b) { return place(a) < place(b); });
  return sorted;
}

Json ClearanceReport::toJson(const NamedRecord& named) const {
  const auto& [names, record] = named;
  Json json{{"a", names.first}, {"b", names.second}, {"distance", Json()}};
  if (record.number < 0) return json;
  json["distance"] = record.closest.result.distance;
  json["lower"] = record.lower;
  json["number"] = record.number;
  json["time"] = record.time;
  if (question_.thresholds) json["level"] = toString(record.level);
  return json;
}

/// The closest state of a pair, with its pieces and what it takes to see it again.
Json ClearanceReport::momentOf(const PairRecord& record) const {
  const scene::RobotModel& robot = question_.model->robot;
  const narrowphase::SignedDistance& result = record.closest.result;
  Json json{{"lower", result.lower_bound},
            {"upper", result.upper_bound},
            {"representation", toString(record.closest.representation)},
            {"depth_is_lower_bound", record.closest.depth_is_lower_bound},
            {"points", {tools::toJson(result.point_a), tools::toJson(result.point_b)}},
            {"positions", Json::object()},
            {"shapes", Json::array()}};
  if (question_.thresholds) {
    json["stop"] = question_.thresholds->stop.of(record.closest.asked);
    json["warn"] = question_.thresholds->warn.of(record.closest.asked);
  }
  for (const scene::JointRange& range : scene::jointRanges(robot))
    json["positions"][robot.joints[range.joint].name] = record.positions[range.joint];
  const scene::BodyPoses poses = scene::forwardKinematics(robot, record.positions);
  for (const scene::ShapeRef& ref : {record.closest.asked.a, record.closest.asked.b}) {
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
    if (records_.find(names) == records_.end())
      pairs.push_back({{"a", names.first}, {"b", names.second}, {"reason", reason[0]}, {"detail", reason[1]}});
  return pairs;
}

Json ClearanceReport::limits() const {
  const std::vector<scene::Joint>& joints = question_.model->robot.joints;
  Json json{{"states", states_beyond_}, {"joints", Json::array()}};
  for (const auto& [joint, excess] : beyond_)
    json["joints"].push_back({{"joint", joints[joint].name},
                              {"states", excess.states},
                              {"first", excess.first},
                              {"position", excess.position},
                              {"lower", joints[joint].lower},
                              {"upper", joints[joint].upper}});
  return json;
}

Json ClearanceReport::toJson() const {
  const scene::SceneModel& model = *question_.model;
  Json json{{"rows", rows_ == RowKind::State ? "state" : "segment"},
            {"curves", curves_},
            {"settings", settingsOf(question_)},
            {"links", fidelityOf(model.robot)},
            {"warnings", model.robot.warnings},
            {"pairs", Json::array()},
            {"moments", Json::array()},
            {"unchecked", uncheckedPairs()},
            {"limits", limits()}};
  for (const std::string& warning : model.pairs.warnings) json["warnings"].push_back(warning);
  for (const NamedRecord* named : sortedRecords()) {
    json["pairs"].push_back(toJson(*named));
    if (named->second.number >= 0 && json["moments"].size() < kMoments)
      json["moments"].push_back(momentOf(named->second));
  }
  return json;
}

}  // namespace proximity_server::tools
