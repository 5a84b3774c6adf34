#include "tools/clearance/clearance_question.h"

#include "tools/text/csv.h"

#include <cmath>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

bool isWanted(scene::PairReason reason) {
  return reason != scene::PairReason::SameBody && reason != scene::PairReason::NoGeometry &&
         reason != scene::PairReason::BothHalfSpaces;
}

/// All pairs with an object that have geometry and are not one body.
void addUnfilteredPairs(const scene::Objects& objects, std::vector<scene::ShapeRefPair>& pairs) {
  const int links = static_cast<int>(objects.model().robot.links.size());
  for (const int object : objects.numbers()) {
    const scene::ShapeRef ref = scene::ShapeRef::ofObject(object);
    for (int link = 0; link < links; ++link)
      if (isWanted(objects.reason(link, ref))) pairs.push_back({link, ref});
    for (const int other : objects.numbers())
      if (const auto second = scene::ShapeRef::ofObject(other); other > object && isWanted(objects.reason(ref, second)))
        pairs.push_back({ref, second});
  }
}

/// The number after the prefix. Throws std::invalid_argument if there is no number, or other text after it.
template <typename Number>
Number numberAfter(const std::string& prefix, const std::string& text) {
  const auto value = numberIn<Number>(text.substr(prefix.size()));
  if (!value) throw std::invalid_argument(text + ": no number behind " + prefix);
  return *value;
}

double thresholdAfter(const std::string& prefix, const std::string& text) {
  const auto threshold = numberAfter<double>(prefix, text);
  if (std::isnan(threshold)) throw std::invalid_argument(text + ": not a number");
  return threshold;
}

}  // namespace

PairSelection readPairSelection(const std::string& text) {
  using Kind = PairSelection::Kind;
  if (text == "all") return {{Kind::All}};
  if (text == "minimum") return {{Kind::Minimum}};
  if (text.compare(0, 8, "minimum:") == 0) {
    PairSelection minimum;
    minimum.accuracy = numberAfter<double>("minimum:", text);
    if (!(minimum.accuracy > 0.0)) throw std::invalid_argument(text + ": the accuracy is not above 0");
    return minimum;
  }
  if (text.compare(0, 6, "below:") == 0) return {{Kind::Below}, thresholdAfter("below:", text)};
  if (text.compare(0, 4, "any:") == 0) return {{Kind::Any}, thresholdAfter("any:", text)};
  if (text.compare(0, 2, "k:") != 0)
    throw std::invalid_argument(text + ": none of all, minimum, minimum:METRES, below:METRES, any:METRES, k:COUNT");
  const int count = numberAfter<int>("k:", text);
  if (count < 1) throw std::invalid_argument(text + ": at least one pair");
  return {{Kind::Closest, count}};
}

std::string textOf(const PairSelection& selection) {
  switch (selection.kind) {
    case PairSelection::Kind::All:
      return "all";
    case PairSelection::Kind::Below:
      return "below:" + shortest(selection.threshold);
    case PairSelection::Kind::Any:
      return "any:" + shortest(selection.threshold);
    case PairSelection::Kind::Closest:
      return "k:" + std::to_string(selection.count);
    case PairSelection::Kind::Minimum:
      break;
  }
  if (selection.accuracy > 0.0) return "minimum:" + shortest(selection.accuracy);
  return "minimum";
}

std::vector<scene::ShapeRefPair> checkedPairs(const scene::SceneModel& model, PairFilter filter) {
  std::vector<scene::ShapeRefPair> pairs;
  for (const scene::LinkPair& pair : model.pairs.pairs) {
    const bool is_checked = filter == PairFilter::On ? pair.reason == scene::PairReason::Checked
                                                     : pair.reason != scene::PairReason::SameBody;
    if (is_checked) pairs.push_back({{pair.link_a, 0}, {pair.link_b, 0}});
  }
  return pairs;
}

void QuestionPairs::take(const scene::Objects& objects) {
  if (question_.candidates) return;
  with_objects_ = question_.pairs;
  addUnfilteredPairs(objects, with_objects_);
}

std::vector<scene::ShapeRefPair> QuestionPairs::list(const scene::Objects* objects) const {
  std::vector<scene::ShapeRefPair> pairs = get().list();
  if (question_.candidates && objects)
    objects->forEachCheckedPair([&](const scene::ShapeRef& a, const scene::ShapeRef& b) { pairs.push_back({a, b}); });
  return pairs;
}

}  // namespace proximity_server::tools
