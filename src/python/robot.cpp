#include "python/robot.h"

#include "proximity_server/scene/model/names.h"

#include <stdexcept>
#include <utility>

namespace proximity_server::python {

struct LoadedRobot {
  LoadedRobot(RobotText robot_text, LoadOptions load_options, const std::atomic<bool>* stop)
      : text(std::move(robot_text)),
        options(std::move(load_options)),
        model(load(text, options, stop)),
        thresholds(thresholdsOf(text, model->robot)),
        batch(model) {}

  /// Each thread takes copies made by forAnotherThread(). It is made when it is first needed.
  const scene::State& state() const {
    std::call_once(has_state, [this] { fresh_state.emplace(model); });
    return *fresh_state;
  }

  RobotText text;
  LoadOptions options;
  std::shared_ptr<const scene::SceneModel> model;
  std::optional<scene::LevelThresholds> thresholds;
  scene::SceneBatch batch;  ///< without objects
  mutable std::once_flag has_state;
  mutable std::optional<scene::State> fresh_state;
};

Robot::Robot(RobotText text, LoadOptions options, int threads, const std::atomic<bool>* stop)
    : loaded_(std::make_shared<const LoadedRobot>(std::move(text), std::move(options), stop)), threads_(1) {
  objects_ = std::make_shared<const scene::Objects>(
      scene::noObjects(loaded_->model, configOf(loaded_->text, loaded_->options).robot.free_objects));
  setThreads(threads);
}

Robot::Robot(std::shared_ptr<const LoadedRobot> loaded, scene::Objects objects, std::vector<scene::WrittenRule> rules,
             int threads)
    : loaded_(std::move(loaded)),
      objects_(std::make_shared<const scene::Objects>(std::move(objects))),
      rules_(std::move(rules)),
      threads_(threads) {}

Robot::~Robot() = default;

const std::shared_ptr<const scene::SceneModel>& Robot::model() const { return loaded_->model; }
const scene::Candidates& Robot::candidates() const { return loaded_->batch.candidates(); }
const RobotText& Robot::text() const { return loaded_->text; }
const LoadOptions& Robot::options() const { return loaded_->options; }
const scene::LevelThresholds* Robot::thresholds() const {
  return loaded_->thresholds ? &*loaded_->thresholds : nullptr;
}

const PairNumbers& Robot::pairs() const {
  std::call_once(pairs_made_, [this] { pairs_.emplace(candidates(), *objects_); });
  return *pairs_;
}

scene::ShapeRef Robot::shapeNamed(const std::string& name) const {
  const int link = model()->robot.findLink(name), object = objects_->find(name);
  if (link >= 0) return link;
  if (object >= 0) return scene::ShapeRef::ofObject(object);
  std::vector<std::string> known = scene::namesOf(model()->robot.links);
  for (const int number : objects_->numbers()) known.push_back(objects_->object(number)->id);
  throw std::invalid_argument("there is no link or object " + scene::unknownName(name, known));
}

void Robot::setThreads(int threads) {
  constexpr int kMost = 1024;
  if (threads < 1 || threads > kMost)
    throw std::invalid_argument("threads is " + std::to_string(threads) + ", but must be from 1 to " +
                                std::to_string(kMost));
  threads_ = threads;
}

// --- objects

std::unique_ptr<Robot> Robot::with(std::vector<scene::ObjectEdit> objects, const std::vector<scene::WrittenRule>& rules,
                                   const std::atomic<bool>* stop, std::vector<std::string>& warnings) const {
  const scene::ObjectOptions options = objectOptions(loaded_->text, loaded_->options, stop);
  scene::LinkFrames frames(model()->robot);
  scene::ObjectEditor editor(*objects_, frames, options);
  for (scene::ObjectEdit& object : objects) {
    const std::string id = object.id, source = object.source;
    object.operation = editor.find(id) ? scene::ObjectEdit::Operation::Replace : scene::ObjectEdit::Operation::Add;
    withNameInErrors(source, [&] { editor.apply(std::move(object)); });
    const std::vector<std::string>& object_warnings = scene::warningsOf(*editor.find(id));
    warnings.insert(warnings.end(), object_warnings.begin(), object_warnings.end());
  }
  return changed(editor, rules);
}

std::unique_ptr<Robot> Robot::edited(scene::ObjectEdit edit, const pybind11::object& q) const {
  const scene::RobotModel& robot = model()->robot;
  scene::BodyPoses poses;
  if (!q.is_none()) {
    const JointPositions state(q, robot);
    if (!state.shape().empty() || !state.block(0, 1).allFinite())
      throw std::invalid_argument("q has to be one state, and finite, for the place of an object");
    std::vector<double> positions;
    positionsOf(state.block(0, 1), 0, positions);
    poses = scene::forwardKinematics(robot, positions);
    edit.pose = scene::ObjectEdit::Pose::Kept;
  }
  const scene::ObjectOptions options;  // they are not used, because no geometry is made
  scene::LinkFrames frames(robot, poses);
  scene::ObjectEditor editor(*objects_, frames, options);
  editor.require(edit.id);
  editor.apply(std::move(edit));
  return changed(editor, {});
}

std::unique_ptr<Robot> Robot::changed(const scene::ObjectEditor& editor,
                                      const std::vector<scene::WrittenRule>& rules) const {
  scene::Objects objects = objects_->changed(editor.difference());
  std::vector<scene::WrittenRule> all_rules = rules_;
  all_rules.insert(all_rules.end(), rules.begin(), rules.end());
  if (!rules.empty()) objects = scene::withRules(objects, all_rules);
  return std::unique_ptr<Robot>(new Robot(loaded_, std::move(objects), std::move(all_rules), threads_));
}

std::unique_ptr<Robot> Robot::allowing(const std::string& a, const std::string& b) const {
  for (const std::string& name : {a, b})
    if (name != "*") static_cast<void>(shapeNamed(name));
  std::vector<std::string> warnings;
  return with({}, {{a, b, scene::AllowedPairs::Rule::Allowed}}, nullptr, warnings);
}

// --- questions

scene::SceneBatch Robot::newBatch() const {
  std::call_once(batch_made_, [this] {
    batch_.emplace(loaded_->batch.forAnotherThread());
    if (!objects_->empty()) batch_->use(objects_);
  });
  return batch_->forAnotherThread();
}

scene::State Robot::newState() const {
  scene::State state = loaded_->state().forAnotherThread();
  state.set(objects_, scene::carriersOnLinks(*objects_));
  return state;
}

std::shared_ptr<Scratch> Robot::borrow() {
  std::unique_ptr<Scratch> scratch;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (free_scratches_.empty()) {
      free_scratches_.reserve(++scratch_count_);  // so that returning a scratch never allocates memory
      free_scratches_.push_back(std::make_unique<Scratch>(*this));
    }
    scratch = std::move(free_scratches_.back());
    free_scratches_.pop_back();
  }
  return {scratch.release(), [this](Scratch* used) {
            const std::lock_guard<std::mutex> lock(mutex_);
            free_scratches_.emplace_back(used);
          }};
}

}  // namespace proximity_server::python
