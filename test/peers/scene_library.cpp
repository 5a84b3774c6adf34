#include "peers/scene_library.h"

#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <tuple>

namespace proximity_server::peers {

using namespace narrowphase;
using namespace scene;
namespace {

bool isBefore(const ShapeRefPair& a, const ShapeRefPair& b) {
  return std::pair(a.a.link(), a.b.link()) < std::pair(b.a.link(), b.b.link());
}

}  // namespace

std::string nameOf(SceneQuestion question) {
  const char* names[] = {"any below 5 cm", "first contact", "minimum", "5 closest", "below 5 cm", "all"};
  return names[static_cast<int>(question)];
}

/// The candidates are sorted as the pairs of the filter are.
int numberOf(const ShapeRefPair& pair, const Candidates& candidates, const Objects* objects) {
  if (pair.b.isObject())
    return static_cast<int>(candidates.size()) + pair.a.link() * objects->numberLimit() + pair.b.object();
  return static_cast<int>(std::lower_bound(candidates.begin(), candidates.end(), pair, isBefore) - candidates.begin());
}

std::vector<std::pair<int, int>> linksOfCandidates(const PairTable& table) {
  std::vector<std::pair<int, int>> links;
  for (const int index : table.checked) {
    const LinkPair& pair = table.pairs[index];
    links.emplace_back(pair.link_a, pair.link_b);
  }
  return links;
}

OurScene::OurScene(std::shared_ptr<const SceneModel> model, Skipping skipping, std::shared_ptr<const Objects> objects)
    : scene_(std::move(model), skipping) {
  if (objects) scene_.use(std::move(objects));
}

void OurScene::ask(const BodyPoses& poses, SceneQuestion question) {
  scene_.update(poses);
  question_ = question;
  const Candidates& candidates = scene_.candidates();
  Question within;
  within.threshold = kBelow;
  Question touching;
  touching.threshold = 0.0;
  touching.depth = Question::Depth::NotWanted;
  switch (question) {
    case SceneQuestion::AnyBelow:
      return take(scene_.first(candidates, within));
    case SceneQuestion::Contact:
      return take(scene_.first(candidates, touching));
    case SceneQuestion::Minimum:
      return take(scene_.minimum(candidates));
    case SceneQuestion::Closest:
      return take(scene_.closest(candidates, kClosest));
    case SceneQuestion::Below:
      return take(scene_.below(candidates, within));
    case SceneQuestion::All:
      return take(scene_.all(candidates));
  }
}

void OurScene::take(const PairProximity* found) {
  first_ = found;
  size_ = found != nullptr ? 1 : 0;
}

void OurScene::take(const std::vector<PairProximity>& found) {
  first_ = found.data();
  size_ = found.size();
}

void OurScene::giveAnswer(SceneAnswer& answer) const {
  answer.pairs.clear();
  answer.is_below = question_ == SceneQuestion::AnyBelow && size_ > 0;
  if (question_ == SceneQuestion::AnyBelow) return;
  for (std::size_t i = 0; i < size_; ++i)
    answer.pairs.push_back(
        {numberOf(first_[i].asked, scene_.candidates(), scene_.objects()), first_[i].result.distance});
}

}  // namespace proximity_server::peers
