// Operations on objects, with frames along a line.
#include "proximity_server/scene/objects/object_editor.h"

#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace proximity_server::scene::object_editor_test {

using Eigen::Isometry3d;
using narrowphase::Sphere;
using Operation = ObjectEdit::Operation;

/// "world" is at 0, "cart" at x = 1, the link "hand" at x = 2; no other frame has a pose.
class FramesOnALine : public ObjectFrames {
 public:
  std::string named(const std::string& name) const override { return name.empty() ? "world" : name; }
  std::string ofLink(const std::string& link) const override { return "frame of " + link; }
  Isometry3d seenFrom(const std::string& frame, const std::string& other, const Isometry3d& pose) override {
    return at(placeOf(other) - placeOf(frame), 0, 0) * pose;
  }

 private:
  static double placeOf(const std::string& frame) {
    if (frame == "world") return 0.0;
    if (frame == "cart") return 1.0;
    if (frame == "frame of hand") return 2.0;
    throw std::invalid_argument("no frame " + frame);
  }
};

ObjectEdit edit(Operation operation, const std::string& id, const ObjectPlace& place = {}) {
  ObjectEdit result;
  result.operation = operation;
  result.id = id;
  result.place = place;
  if (operation == Operation::Add || operation == Operation::Replace || operation == Operation::Append)
    result.shapes = {{narrowphase::Shape(Sphere{0.1})}};
  return result;
}

ObjectEdit keeping(ObjectEdit edit) {
  edit.pose = ObjectEdit::Pose::Kept;
  return edit;
}

class AnEditor : public testing::Test {
 protected:
  static Objects tableAndBar() {
    auto model = std::make_shared<SceneModel>();
    model->robot = robotOf(
        urdfOf(link("hand") + link("finger") + link("arm") + weld("1", "hand", "finger") + weld("2", "hand", "arm")));
    const std::vector<ObjectShape> ball{{narrowphase::Shape(Sphere{0.1})}};
    return Objects(model).changed({AddObject{makeObject("table", ball, Fixed{at(4, 0, 0)})},
                                   AddObject{makeObject("bar", ball, Attached{"hand", {"finger"}, at(1, 0, 0)})}});
  }

  double placeOf(const std::string& id) const { return poseInCarrier(*editor_.find(id)).translation().x(); }
  std::string carrierOf(const std::string& id) const { return scene::carrierOf(*editor_.find(id), frames_); }
  std::string refusal(const ObjectEdit& refused) {
    return errorOf([&] { editor_.apply(refused); });
  }

  const Objects before_ = tableAndBar();
  FramesOnALine frames_;
  const ObjectOptions options_{};
  ObjectEditor editor_{before_, frames_, options_};
};

TEST_F(AnEditor, CarriesAPoseOverIntoTheFrameOfTheObject) {
  editor_.apply(edit(Operation::Add, "part", {"", {}, "cart", at(1, 0, 0), "frame of hand"}));
  EXPECT_EQ(carrierOf("part"), "cart");
  EXPECT_EQ(placeOf("part"), 2.0);
  editor_.apply(edit(Operation::Move, "part", {"", {}, "", at(7, 0, 0)}));
  EXPECT_EQ(carrierOf("part"), "world");
  EXPECT_EQ(placeOf("part"), 7.0);
}

TEST_F(AnEditor, AttachesAndDetachesWhereTheObjectIs) {
  editor_.apply(keeping(edit(Operation::Attach, "table", {"hand", {"arm"}, ""})));
  EXPECT_EQ(carrierOf("table"), "frame of hand");
  EXPECT_EQ(placeOf("table"), 2.0);
  EXPECT_EQ(std::get<Attached>(editor_.find("table")->placement).touch_links, std::vector<std::string>{"arm"});
  editor_.apply(keeping(edit(Operation::Detach, "bar", {"", {}, "cart"})));
  EXPECT_EQ(carrierOf("bar"), "cart");
  EXPECT_EQ(placeOf("bar"), 2.0);
}

TEST_F(AnEditor, SharesTheGeometryWhereOnlyThePlaceIsNew) {
  editor_.apply(edit(Operation::Move, "table", {"", {}, "", at(7, 0, 0)}));
  EXPECT_EQ(editor_.find("table")->geometry, before_.object(before_.find("table"))->geometry);
}

TEST_F(AnEditor, AppendsShapesWhereTheyAreAndTouchLinks) {
  editor_.apply(edit(Operation::Append, "bar", {"", {"arm"}, "", at(5, 0, 0), "world"}));
  const std::vector<ObjectShape>& shapes = givenShapesOf(*editor_.find("bar"));
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes[1].object_T_shape.translation().x(), 2.0) << "the bar is at x = 3";
  EXPECT_EQ(placeOf("bar"), 1.0);
  EXPECT_EQ(std::get<Attached>(editor_.find("bar")->placement).touch_links,
            (std::vector<std::string>{"finger", "arm"}));
}

TEST_F(AnEditor, RefusesWithIdAndReason) {
  EXPECT_EQ(refusal(edit(Operation::Add, "bar")), "object \"bar\": id: there is an object with this id already");
  EXPECT_EQ(refusal(edit(Operation::Move, "bar")),
            "object \"bar\": operation: link \"hand\" holds it: DETACH it, or ATTACH it elsewhere");
  EXPECT_EQ(refusal(edit(Operation::Detach, "table")), "object \"table\": operation: no link holds it");
  EXPECT_EQ(refusal(edit(Operation::Move, "tabel")),
            "object \"tabel\": id: there is no object with this id (did you mean \"table\"?)");
  EXPECT_EQ(refusal(edit(Operation::Replace, "*")), "object \"*\": id: it stands for all objects");
  EXPECT_EQ(refusal(edit(Operation::Remove, "")), "object \"\": id: it is empty");
  EXPECT_EQ(refusal(edit(Operation::Attach, "table", {"hamd", {}, ""})),
            "object \"table\": link: there is no link \"hamd\" (did you mean \"hand\"?)");
  EXPECT_EQ(refusal(edit(Operation::Append, "table", {"", {"arm"}, ""})),
            "object \"table\": touch_links: no link holds the object");
  EXPECT_EQ(refusal(edit(Operation::Add, "part", {"", {}, "", at(0, 0, 0), "nowhere"})), "no frame nowhere");
  ObjectEdit empty = edit(Operation::Add, "part");
  empty.shapes.clear();
  EXPECT_EQ(refusal(empty), "object \"part\": it has no shape");
  EXPECT_TRUE(editor_.changed().empty());
}

TEST_F(AnEditor, TakesBackWhatIsNotKept) {
  editor_.apply(edit(Operation::Move, "table", {"", {}, "", at(7, 0, 0)}));
  editor_.keep();
  editor_.apply(edit(Operation::Remove, "*"));
  editor_.apply(edit(Operation::Add, "part"));
  EXPECT_EQ(editor_.ids(), std::vector<std::string>{"part"});
  editor_.undo();
  EXPECT_EQ(editor_.ids(), (std::vector<std::string>{"bar", "table"}));
  EXPECT_EQ(placeOf("table"), 7.0);
}

TEST_F(AnEditor, TellsTheDifferenceInTheOrderOfTheOperations) {
  editor_.apply(edit(Operation::Add, "z"));
  editor_.apply(edit(Operation::Add, "gone"));
  editor_.apply(edit(Operation::Remove, "bar"));
  editor_.apply(edit(Operation::Remove, "gone"));
  editor_.apply(edit(Operation::Replace, "table"));
  editor_.apply(edit(Operation::Replace, "a"));
  const std::vector<ObjectChange> changes = editor_.difference();
  ASSERT_EQ(changes.size(), 4u);
  EXPECT_EQ(std::get<AddObject>(changes[0]).object.id, "z");
  EXPECT_EQ(std::get<RemoveObject>(changes[1]).id, "bar");
  EXPECT_EQ(std::get<ReplaceObject>(changes[2]).object.id, "table");
  EXPECT_EQ(std::get<AddObject>(changes[3]).object.id, "a");
}

}  // namespace proximity_server::scene::object_editor_test
