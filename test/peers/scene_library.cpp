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

Question within(double distance) {
  Question question;
  question.threshold = distance;
  return question;
}

/// The candidates are sorted as the pairs of the filter are.
int numberOf(const ShapeRefPair& pair, const Candidates& candidates, const Objects* objects) {
  if (pair.b.isObject())
    return static_cast<int>(candidates.size()) + pair.a.link() * objects->numberLimit() + pair.b.object();
  return static_cast<int>(std::lower_bound(candidates.begin(), candidates.end(), pair, isBefore) - candidates.begin());
}

OurScene::OurScene(std::shared_ptr<const SceneModel> model, Skipping skipping, std::shared_ptr<const Objects> objects)
    : scene_(std::move(model), skipping) {
  if (objects) scene_.use(std::move(objects));
}

void OurScene::ask(const BodyPoses& poses, SceneQuestion question) {
  scene_.update(poses);
  if (question == SceneQuestion::Minimum) {
    first_ = scene_.minimum(scene_.candidates());
    size_ = first_ != nullptr ? 1 : 0;
    return;
  }
  const std::vector<PairProximity>& found = question == SceneQuestion::Below
                                                ? scene_.below(scene_.candidates(), within(kBelow))
                                                : scene_.all(scene_.candidates());
  first_ = found.data();
  size_ = found.size();
}

std::vector<PairDistance> OurScene::answer() const {
  std::vector<PairDistance> answer;
  for (std::size_t i = 0; i < size_; ++i)
    answer.push_back({numberOf(first_[i].asked, scene_.candidates(), scene_.objects()), first_[i].result.distance});
  return answer;
}

}  // namespace proximity_server::peers
