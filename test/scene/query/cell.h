#pragma once

#include "scene/posed_scene.h"
#include "scene/small_robots.h"

#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// Floating links "0", "1", ... of primitives and meshes, with objects. The same is asked of two scenes: one skips
/// pairs.
class Cell {
 public:
  explicit Cell(const std::vector<std::string>& links, double tolerance = 0.0, const ModelOptions& options = {}) {
    ModelOptions all = options;
    all.mesh_tolerance = tolerance;
    model_ = modelOf(floatingLinks(links, all));
    objects_ = std::make_shared<const Objects>(model_);
    for (const Skipping skipping : {Skipping::On, Skipping::Off}) {
      scenes_.emplace_back(model_, skipping);
      scenes_.back().use(objects_);
    }
  }

  void change(const std::vector<ObjectChange>& changes) {
    objects_ = std::make_shared<const Objects>(objects_->changed(changes));
    for (PosedScene& scene : scenes_) scene.use(objects_);
  }
  void move(const std::string& id, const Placement& placement) {
    change({ReplaceObject{{id, objects_->object(objects_->find(id))->geometry, placement}}});
  }
  void put(const std::vector<Eigen::Isometry3d>& poses, const FramePoses& frames = {}) {
    for (PosedScene& scene : scenes_) scene.update(posesOf(model_->robot, poses), frames);
  }
  PosedScene& scene() { return scenes_.front(); }
  PosedScene& withoutSkipping() { return scenes_.back(); }
  const RobotModel& robot() const { return model_->robot; }
  const std::shared_ptr<const Objects>& objects() const { return objects_; }
  ShapeRef link(const char* name) const { return {model_->robot.findLink(name)}; }
  ShapeRef object(const char* id) const { return ShapeRef::ofObject(objects_->find(id)); }
  PairProximity between(const ShapeRef& a, const ShapeRef& b, const Question& question = {}) {
    return scene().proximity({a, b}, question);
  }

 private:
  std::shared_ptr<const SceneModel> model_;
  std::shared_ptr<const Objects> objects_;
  std::vector<PosedScene> scenes_;
};

/// A mesh becomes its triangles where no tolerance is given.
inline AddObject add(const std::string& id, const std::vector<ObjectShape>& shapes, const Placement& placement,
                     double padding = 0.0, double mesh_tolerance = 0.0) {
  ObjectOptions options;
  options.padding = padding;
  options.meshes.tolerance = mesh_tolerance;
  return {makeObject(id, shapes, placement, options)};
}

}  // namespace proximity_server::scene
