#include "tools/prove/certificate_file.h"

#include "proximity_server/scene/model/names.h"
#include "tools/prove/proof_json.h"
#include "tools/sweep/digests.h"
#include "tools/text/content_hash.h"
#include "tools/text/csv.h"

#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;
using scene::CertificateNode;
using scene::PairCertificate;
using scene::SeparatingAxis;

constexpr int kFormat = 1;

std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// By name, the hashes of what the certificate is about.
Json hashesOf(const CertificateSubject& subject) {
  const ModelDigest model = digestOf(subject.model);
  Json hashes{{"joints", model.joints}, {"shapes", model.shapes}, {"pairs", model.pairs}, {"objects", ""}};
  if (!subject.objects) return hashes;
  std::vector<scene::Object> objects;
  for (const int number : subject.objects->numbers()) objects.push_back(*subject.objects->object(number));
  hashes["objects"] = ContentHash().add(shapesDigestOf(objects)).add(subject.objects_text).text();
  return hashes;
}

Json axisOf(const SeparatingAxis& axis, const scene::RobotModel& robot) {
  return {robot.links[axis.link].name, axis.direction.x(), axis.direction.y(), axis.direction.z()};
}

Json nodeOf(const CertificateNode& node, const scene::RobotModel& robot) {
  if (node.joint >= 0) return {{"joint", robot.joints[node.joint].name}, {"at", node.at}};
  Json axes = Json::array();
  for (const SeparatingAxis& axis : node.axes) axes.push_back(axisOf(axis, robot));
  return {{"axes", axes}};
}

std::string textOf(const PairCertificate& pair, const CertificateSubject& subject) {
  const auto name = [&](const scene::ShapeRef& ref) {
    return dumped(scene::nameOf(ref, subject.model.robot, subject.objects));
  };
  std::string text = "  {\"a\": " + name(pair.pair.a) + ", \"b\": " + name(pair.pair.b) +
                     ", \"bound\": " + dumped(pair.bound) + ", \"tree\": [\n";
  for (const CertificateNode& node : pair.tree)
    text += (&node == pair.tree.data() ? "    " : ",\n    ") + dumped(nodeOf(node, subject.model.robot));
  return text + "]}";
}

/// A value in the JSON, with its place for errors.
class Value {
 public:
  Value(const Json& json, std::string place) : json_(json), place_(std::move(place)) {}

  [[noreturn]] void refuse(const std::string& reason) const { throw std::invalid_argument(place_ + ": " + reason); }

  bool has(const std::string& name) const { return json_.is_object() && json_.contains(name); }
  Value member(const std::string& name) const {
    if (!has(name)) refuse("there is no \"" + name + "\"");
    return {json_[name], place_ + "." + name};
  }
  std::vector<Value> list() const {
    if (!json_.is_array()) refuse("is no list");
    std::vector<Value> values;
    for (const Json& element : json_) values.emplace_back(element, place_ + "[" + std::to_string(values.size()) + "]");
    return values;
  }
  std::vector<Value> list(std::size_t size) const {
    std::vector<Value> values = list();
    if (values.size() != size) refuse("has not " + std::to_string(size) + " elements");
    return values;
  }
  std::vector<std::string> names() const {
    if (!json_.is_object()) refuse("is no object");
    std::vector<std::string> names;
    for (const auto& member : json_.items()) names.push_back(member.key());
    return names;
  }
  std::string text() const {
    if (!json_.is_string()) refuse("is no text");
    return json_;
  }
  double number() const {
    if (!json_.is_number()) refuse("is no number");
    return json_;
  }

 private:
  const Json& json_;
  const std::string place_;
};

class Reader {
 public:
  explicit Reader(const CertificateSubject& subject) : subject_(subject), robot_(subject.model.robot) {}

  ApartCertificate read(const Value& file) const {
    if (file.member("format").number() != kFormat) file.member("format").refuse("is not 1: another version wrote this");
    requireSameSubject(file.member("hashes"));
    ApartCertificate certificate;
    certificate.contact_distance = file.member("contact_distance").number();
    if (!(certificate.contact_distance >= 0.0)) file.member("contact_distance").refuse("is negative");
    for (const std::string& joint : file.member("box").names()) {
      const std::vector<Value> ends = file.member("box").member(joint).list(2);
      certificate.box.push_back({jointNamed(joint, file.member("box")), ends[0].number(), ends[1].number()});
    }
    for (const Value& pair : file.member("pairs").list()) certificate.pairs.push_back(pairIn(pair, certificate));
    return certificate;
  }

 private:
  void requireSameSubject(const Value& hashes) const {
    const Json ours = hashesOf(subject_);
    for (const auto& [name, hash] : ours.items())
      if (const Value there = hashes.member(name); there.text() != hash)
        there.refuse("is " + there.text() + ", but that of this robot is " + std::string(hash) + ": other " + name);
  }

  int jointNamed(const std::string& name, const Value& place) const {
    const int joint = scene::findNamed(robot_.joints, name);
    if (joint < 0) place.refuse("there is no movable joint " + scene::unknownName(name, scene::namesOf(robot_.joints)));
    return joint;
  }

  int linkNamed(const Value& name) const {
    const int link = robot_.findLink(name.text());
    if (link < 0) name.refuse("there is no link " + scene::unknownName(name.text(), scene::namesOf(robot_.links)));
    return link;
  }

  scene::ShapeRef shapeNamed(const Value& name) const {
    const int object = subject_.objects ? subject_.objects->find(name.text()) : -1;
    return object >= 0 ? scene::ShapeRef::ofObject(object) : scene::ShapeRef(linkNamed(name));
  }

  PairCertificate pairIn(const Value& value, const ApartCertificate& certificate) const {
    PairCertificate pair{
        {shapeNamed(value.member("a")), shapeNamed(value.member("b"))}, value.member("bound").number(), {}};
    if (!(pair.bound > certificate.contact_distance)) value.member("bound").refuse("is not above the contact distance");
    for (const Value& node : value.member("tree").list()) pair.tree.push_back(nodeIn(node));
    return pair;
  }

  CertificateNode nodeIn(const Value& value) const {
    CertificateNode node;
    if (value.has("joint")) {
      node.joint = jointNamed(value.member("joint").text(), value);
      node.at = value.member("at").number();
      return node;
    }
    for (const Value& axis : value.member("axes").list()) {
      const std::vector<Value> parts = axis.list(4);
      node.axes.push_back({linkNamed(parts[0]), {parts[1].number(), parts[2].number(), parts[3].number()}});
    }
    return node;
  }

  const CertificateSubject& subject_;
  const scene::RobotModel& robot_;
};

}  // namespace

std::string nameOf(const scene::ShapeRefPair& pair, const CertificateSubject& subject) {
  const scene::RobotModel& robot = subject.model.robot;
  return scene::nameOf(pair.a, robot, subject.objects) + " - " + scene::nameOf(pair.b, robot, subject.objects);
}

std::string certificateText(const ApartCertificate& certificate, const CertificateSubject& subject) {
  std::string text = "{\"format\": " + std::to_string(kFormat) + ",\n \"robot\": " + dumped(subject.model.robot.name) +
                     ",\n \"hashes\": " + dumped(hashesOf(subject)) +
                     ",\n \"contact_distance\": " + dumped(certificate.contact_distance) +
                     ",\n \"box\": " + dumped(boxJson(certificate.box, subject.model.robot)) + ",\n \"pairs\": [\n";
  for (const PairCertificate& pair : certificate.pairs)
    text += (&pair == certificate.pairs.data() ? "" : ",\n") + textOf(pair, subject);
  return text + "]}\n";
}

ApartCertificate readCertificate(const std::string& text, const CertificateSubject& subject) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(std::string("no JSON: ") + error.what());
  }
  return Reader(subject).read({json, "certificate"});
}

}  // namespace proximity_server::tools
