#include "tools/robot/object_schedule.h"

#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "tools/text/naming.h"

#include <stdexcept>
#include <variant>

namespace proximity_server::tools {
namespace {

bool isDue(const scene::Moment& moment, long row, double time) {
  if (const auto* at_row = std::get_if<scene::AtRow>(&moment)) return at_row->row <= row;
  return std::get<scene::AtTime>(moment).time <= time;
}

}  // namespace

ObjectSchedule::ObjectSchedule(const std::shared_ptr<const scene::SceneModel>& model, const scene::ObjectFile& file,
                               const scene::ObjectOptions& options, scene::ObjectRules::FreeObjects free_objects)
    : model_(model),
      options_(options),
      now_(std::make_shared<const scene::Objects>(withRules(scene::noObjects(model, free_objects), file.rules))),
      steps_(file.changes) {
  std::vector<scene::ObjectEdit> objects = file.objects;
  for (scene::ObjectEdit& object : objects) makeGeometry(object);
  for (scene::WrittenChange& step : steps_)
    if (!step.edit.shapes.empty()) makeGeometry(step.edit);
  try {
    apply(objects, {});
  } catch (const std::invalid_argument&) {  // one by one, to name the place of the one that is refused
    for (const scene::ObjectEdit& object : objects) naming(object.source, [&] { apply({object}, {}); });
  }
  const auto start = now_;
  const scene::BodyPoses zero =
      scene::forwardKinematics(model_->robot, scene::Positions(model_->robot.joints.size(), 0.0));
  for (const scene::WrittenChange& step : steps_) naming(step.edit.source, [&] { apply({step.edit}, zero); });
  now_ = start;
}

void ObjectSchedule::advance(long row, double time, const scene::Positions& positions) {
  if (next_ == steps_.size() || !isDue(steps_[next_].at, row, time)) return;
  const scene::BodyPoses poses = scene::forwardKinematics(model_->robot, positions);
  for (; next_ < steps_.size() && isDue(steps_[next_].at, row, time); ++next_)
    naming(steps_[next_].edit.source, [&] { apply({steps_[next_].edit}, poses); });
}

std::optional<double> ObjectSchedule::nextTime() const {
  const auto* at_time = next_ < steps_.size() ? std::get_if<scene::AtTime>(&steps_[next_].at) : nullptr;
  return at_time ? std::optional<double>(at_time->time) : std::nullopt;
}

bool ObjectSchedule::hasTimes() const {
  for (const scene::WrittenChange& step : steps_)
    if (std::holds_alternative<scene::AtTime>(step.at)) return true;
  return false;
}

std::string ObjectSchedule::leftOver() const {
  if (next_ == steps_.size()) return "";
  const std::size_t left = steps_.size() - next_;
  return std::to_string(left) + (left == 1 ? " change of objects was" : " changes of objects were") +
         " never made, because the states end before: the first is that of " + steps_[next_].edit.source;
}

void ObjectSchedule::apply(const std::vector<scene::ObjectEdit>& edits, const scene::BodyPoses& poses) {
  scene::LinkFrames frames(model_->robot, poses);
  scene::ObjectEditor editor(*now_, frames, options_);
  for (const scene::ObjectEdit& edit : edits) editor.apply(edit);
  now_ = std::make_shared<const scene::Objects>(now_->changed(editor.difference()));
}

/// Makes the geometry of the shapes, which are not needed any more then.
void ObjectSchedule::makeGeometry(scene::ObjectEdit& edit) {
  scene::ObjectOptions padded = options_;
  padded.padding = edit.padding;
  all_.push_back(naming(edit.source, [&] { return scene::makeObject(edit.id, edit.shapes, scene::Fixed{}, padded); }));
  edit.geometry = all_.back().geometry;
  edit.shapes.clear();
  for (const std::string& warning : scene::warningsOf(all_.back()))
    warnings_.push_back("object " + scene::quoted(edit.id) + ": " + warning);
}

std::shared_ptr<ObjectSchedule> loadObjects(const std::string& path, const RobotFiles& robot,
                                            const std::shared_ptr<const scene::SceneModel>& model) {
  const scene::RobotConfig config = configOf(robot).robot;
  if (path.empty() && config.objects.objects.empty()) return nullptr;
  scene::ObjectOptions how;
  how.resolve = meshResolver(config);
  how.meshes.tolerance = config.model.mesh_tolerance;
  how.meshes.cache = config.model.mesh_cache;
  how.meshes.time_budget = config.model.mesh_time_budget;
  const scene::ObjectFile file = path.empty() ? config.objects : scene::readObjectFile(path);
  printWarnings(file.warnings, robot.warnings);
  auto schedule = std::make_shared<ObjectSchedule>(model, file, how, config.free_objects);
  printWarnings(schedule->warnings(), robot.warnings);
  return schedule;
}

}  // namespace proximity_server::tools
