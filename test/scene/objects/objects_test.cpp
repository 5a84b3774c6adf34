#include "proximity_server/scene/objects/objects.h"

#include "chance.h"
#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>
#include <tuple>

namespace proximity_server::scene::objects_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// base (no joint above it), arm, hand with a fixed finger, and a camera without geometry.
std::shared_ptr<const SceneModel> arm() {
  return modelOf(urdfOf(link("base", ball("0.1")) + link("arm", ball("0.1", "0 0 1")) +
                        link("hand", ball("0.1", "0 0 2")) + link("finger", ball("0.1", "0 0 2.2")) + link("camera") +
                        hinge("1", "base", "arm", "0 0 1") + hinge("2", "arm", "hand", "0 0 1") +
                        weld("3", "hand", "finger") + hinge("4", "base", "camera", "0 0 1")));
}

Object thing(const std::string& id, const Placement& placement = Fixed{}) {
  return makeObject(id, {{Shape(Box{{0.1, 0.2, 0.3}})}}, placement);
}

Object floorOf(const std::string& id, const Placement& placement = Fixed{}) {
  return makeObject(id, {{HalfSpace{{0, 0, 1}, 0.0}}}, placement);
}

class ObjectsOfAnArm : public testing::Test {
 protected:
  int link(const char* name) const { return model_->robot.findLink(name); }
  PairReason reason(const Objects& objects, const char* link_name, const std::string& id) const {
    return objects.reason(link(link_name), ShapeRef::ofObject(objects.find(id)));
  }
  static PairReason between(const Objects& objects, const std::string& a, const std::string& b) {
    return objects.reason(ShapeRef::ofObject(objects.find(a)), ShapeRef::ofObject(objects.find(b)));
  }
  std::string refusal(const std::vector<ObjectChange>& changes) const {
    return errorOf([&] { some_.changed(changes); });
  }

  /// One of some_ in another place.
  ObjectChange placed(const std::string& id, const Placement& placement) const {
    return ReplaceObject{{id, some_.object(some_.find(id))->geometry, placement}};
  }

  const std::shared_ptr<const SceneModel> model_ = arm();
  const Objects none_{model_};
  const Objects some_ = none_.changed({AddObject{thing("table")}, AddObject{thing("cart", Moving{"cart_frame"})},
                                       AddObject{thing("bar", Attached{"hand"})}});
};

// --- changes

TEST_F(ObjectsOfAnArm, AChangeMakesTheNextAndLeavesTheLast) {
  const Objects next = some_.changed({RemoveObject{"table"}, AddObject{thing("box")}});
  EXPECT_GE(some_.find("table"), 0);
  EXPECT_EQ(some_.find("box"), -1);
  EXPECT_EQ(next.find("table"), -1);
  EXPECT_GE(next.find("box"), 0);
  EXPECT_EQ(next.size(), 3);
}

TEST_F(ObjectsOfAnArm, AChangeSharesWhatIsTheSame) {
  const Objects next = some_.changed({AddObject{thing("box")}});
  for (const char* id : {"table", "cart", "bar"}) {
    EXPECT_EQ(next.find(id), some_.find(id));
    EXPECT_EQ(next.object(next.find(id)), some_.object(some_.find(id)));
  }
}

TEST_F(ObjectsOfAnArm, AMovedObjectKeepsItsNumberAndItsGeometry) {
  const int number = some_.find("table");
  const Objects next = some_.changed({placed("table", Fixed{at(1, 0, 0)})});
  EXPECT_EQ(next.find("table"), number);
  EXPECT_EQ(next.object(number)->geometry, some_.object(number)->geometry);
  EXPECT_EQ(std::get<Fixed>(next.object(number)->placement).world_T_object.translation().x(), 1.0);
}

TEST_F(ObjectsOfAnArm, AllChangesAreMadeOrNone) {
  EXPECT_EQ(refusal({AddObject{thing("box")}, RemoveObject{"tabel"}}),
            "there is no object \"tabel\" (did you mean \"table\"?)");
  EXPECT_EQ(some_.find("box"), -1);
}

TEST_F(ObjectsOfAnArm, ChangesOfABatchSeeThoseBeforeThem) {
  const Objects next = some_.changed({AddObject{thing("box")}, ReplaceObject{thing("box", Attached{"hand"})},
                                      RemoveObject{"box"}, AddObject{thing("box")}});
  EXPECT_GE(next.find("box"), 0);
}

TEST_F(ObjectsOfAnArm, FramesAreThoseOfMovingObjects) {
  EXPECT_EQ(some_.frames(), std::vector<std::string>{"cart_frame"});
  const Objects next =
      some_.changed({AddObject{thing("lid", Moving{"cart_frame"})}, AddObject{thing("lift", Moving{"a_lift"})}});
  EXPECT_EQ(next.frames(), (std::vector<std::string>{"a_lift", "cart_frame"}));
  EXPECT_TRUE(some_.changed({placed("bar", Fixed{}), RemoveObject{"cart"}}).frames().empty());
}

// --- refusals

TEST_F(ObjectsOfAnArm, AreRefusedWithIdAndReason) {
  Isometry3d broken = Isometry3d::Identity();
  broken.translation().x() = kNan;
  EXPECT_EQ(refusal({AddObject{thing("table")}}), "object \"table\": there is one with this id already");
  EXPECT_EQ(refusal({AddObject{thing("hand")}}), "object \"hand\": id: a link has this name");
  EXPECT_EQ(refusal({AddObject{thing("")}}), "object \"\": id: it is empty");
  EXPECT_EQ(refusal({AddObject{thing("*")}}), "object \"*\": id: it stands for all objects");
  EXPECT_EQ(refusal({AddObject{thing("box", Fixed{broken})}}),
            "object \"box\": its pose is not finite, or no rotation");
  EXPECT_EQ(refusal({AddObject{thing("box", Moving{""})}}), "object \"box\": the name of its frame is empty");
  EXPECT_EQ(refusal({AddObject{thing("box", Attached{"hnd"})}}),
            "object \"box\": link: there is no link \"hnd\" (did you mean \"hand\"?)");
  EXPECT_EQ(refusal({AddObject{thing("box", Attached{"hand", {"finge"}})}}),
            "object \"box\": touch_links: there is no link \"finge\" (did you mean \"finger\"?)");
  EXPECT_EQ(refusal({AddObject{floorOf("floor", Attached{"hand"})}}),
            "object \"floor\": a half-space cannot be attached");
  EXPECT_EQ(refusal({AddObject{thing("box", Attached{"hand", {}, at(2e6, 0, 0)})}}),
            "object \"box\": it is farther than 1e6 m from its frame");
  EXPECT_EQ(refusal({ReplaceObject{thing("chair")}}), "there is no object \"chair\"");
  EXPECT_EQ(refusal({AddObject{{"empty", nullptr, Fixed{}}}}), "object \"empty\": it has no geometry");
}

TEST(AnObject, IsRefusedWithItsIdAndShape) {
  const auto refusal = [](const std::vector<ObjectShape>& shapes, const ObjectOptions& options = {}) {
    return errorOf([&] { makeObject("box", shapes, Fixed{}, options); });
  };
  Isometry3d broken = Isometry3d::Identity();
  broken.linear()(0, 0) = 2.0;
  const ObjectShape good{Shape(Sphere{0.1})};
  ObjectOptions shrunk;
  shrunk.padding = -0.2;
  const Eigen::AlignedBox3d flat{Vector3d(0, 0, 0), Vector3d(1, 0, 1)}, lost{Vector3d(kNan, 0, 0), Vector3d(1, 1, 1)};
  EXPECT_EQ(refusal({}), "object \"box\": it has no shape");
  EXPECT_EQ(refusal({good, {Shape(Sphere{0.1}), broken}}),
            "object \"box\": shape 2: its pose is not finite, or no rotation");
  EXPECT_EQ(refusal({{Boxes{}}}), "object \"box\": shape 1: there are no boxes");
  EXPECT_EQ(refusal({{Boxes{{flat}}}}).substr(0, 30), "object \"box\": shape 1: box 1: ");
  EXPECT_EQ(refusal({{Boxes{{lost}}}}), "object \"box\": shape 1: box 1: its place is not finite");
  EXPECT_EQ(refusal({{TriangleMesh{}}}), "object \"box\": shape 1: the mesh has no triangle");
  EXPECT_EQ(refusal({{TriangleMesh{{{0, 0, kNan}}, {{0, 0, 0}}}}}),
            "object \"box\": shape 1: a vertex of the mesh is not finite");
  EXPECT_EQ(refusal({{TriangleMesh{{{0, 0, 0}, {1e160, 0, 0}, {0, 1e160, 0}}, {{0, 1, 2}}}}}),
            "object \"box\": shape 1: a vertex of the mesh is at (1e+160      0      0) m, farther than 1e6 m from its "
            "origin");
  EXPECT_EQ(refusal({{TriangleMesh{{{0, 0, 0}}, {{0, 0, 1}}}}}),
            "object \"box\": shape 1: a triangle of the mesh names vertex 1 of 1");
  EXPECT_EQ(refusal({{MeshFile{"package://x/y.stl"}}}),
            "object \"box\": shape 1: there is no resolver for mesh package://x/y.stl");
  EXPECT_NE(refusal({{HalfSpace{{0, 0, 0}, 1.0}}}), "");
  EXPECT_NE(refusal({{HalfSpace{{0, 0, 1}, kNan}}}), "");
  EXPECT_EQ(refusal({{HalfSpace{{0, 0, 1e300}, 1.0}}}), "");  // of any length
  EXPECT_EQ(refusal({{HalfSpace{{1e-300, 0, 1e-310}, 1.0}}}), "");
  EXPECT_NE(refusal({good}, shrunk), "");
  EXPECT_EQ(refusal({{Shape(Sphere{0.1}), at(2e6, 0, 0)}}).substr(0, 34), "object \"box\": shape 1: it reaches ");
  EXPECT_EQ(refusal({good}), "");
}

TEST(AnObject, TellsItsShapes) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  const Object object = makeObject("tool", {{Shape(Sphere{1})}, {mesh}, {HalfSpace{{0, 0, 1}, 0.0}}}, Fixed{});
  ASSERT_EQ(shapesOf(object).size(), 3u);
  EXPECT_EQ(shapesOf(object)[0].description, "sphere");
  EXPECT_EQ(shapesOf(object)[1].description, "mesh of 4 triangles");
  EXPECT_EQ(shapesOf(object)[1].representation, Representation::Exact);
  EXPECT_EQ(shapesOf(object)[2].description, "half-space");
  EXPECT_TRUE(warningsOf(object).empty());
}

TEST(AnObject, AsLargeAsIfItWereInMillimetresIsAWarning) {
  const auto warnings = [](double radius, double x) {
    return warningsOf(makeObject("box", {{Shape(Sphere{0.1})}, {Shape(Sphere{radius}), at(x, 0, 0)}}, Fixed{}));
  };
  EXPECT_TRUE(warnings(50.0, 40.0).empty());
  const std::vector<std::string> of_large{
      "object \"box\": shape 2 reaches 1e+03 m from the frame of the object: are its numbers in millimetres?"};
  EXPECT_EQ(warnings(1000.0, 0.0), of_large);
  EXPECT_EQ(warnings(0.1, 1000.0), of_large);
}

// --- reasons

TEST_F(ObjectsOfAnArm, AreCheckedAgainstLinksWithGeometry) {
  EXPECT_EQ(reason(some_, "base", "table"), PairReason::Checked);
  EXPECT_EQ(reason(some_, "arm", "cart"), PairReason::Checked);
  EXPECT_EQ(reason(some_, "camera", "table"), PairReason::NoGeometry);
}

TEST_F(ObjectsOfAnArm, AttachedOnesAreOfTheBodyOfTheirLink) {
  EXPECT_EQ(reason(some_, "hand", "bar"), PairReason::SameBody);
  EXPECT_EQ(reason(some_, "finger", "bar"), PairReason::SameBody);
  EXPECT_EQ(reason(some_, "arm", "bar"), PairReason::Checked);
  EXPECT_EQ(between(some_, "bar", "table"), PairReason::Checked);
  EXPECT_EQ(between(some_, "cart", "bar"), PairReason::Checked);
  const Objects two = some_.changed({AddObject{thing("screw", Attached{"finger"})}});
  EXPECT_EQ(between(two, "bar", "screw"), PairReason::SameBody);
  const Objects apart = some_.changed({AddObject{thing("screw", Attached{"arm"})}});
  EXPECT_EQ(between(apart, "bar", "screw"), PairReason::Checked);
}

TEST_F(ObjectsOfAnArm, MayTouchTheirTouchLinks) {
  const Objects held = some_.changed({placed("bar", Attached{"hand", {"arm"}})});
  EXPECT_EQ(reason(held, "arm", "bar"), PairReason::TouchLink);
  EXPECT_EQ(reason(held, "base", "bar"), PairReason::Checked);
  const Objects down = held.changed({placed("bar", Fixed{})});
  EXPECT_EQ(reason(down, "arm", "bar"), PairReason::Checked);
  EXPECT_EQ(reason(down, "hand", "bar"), PairReason::Checked);
}

TEST_F(ObjectsOfAnArm, ThatAreNotAttachedAreCheckedAgainstEachOtherOnlyIfAskedAndOneMoves) {
  ObjectRules rules;
  rules.free_objects = ObjectRules::FreeObjects::Checked;
  const Objects more = some_.changed({AddObject{thing("wall")}, AddObject{thing("lid", Moving{"cart_frame"})},
                                      AddObject{thing("lift", Moving{"lift_frame"})}});
  EXPECT_EQ(between(more, "table", "wall"), PairReason::BothStatic);
  EXPECT_EQ(between(more, "table", "cart"), PairReason::FreeObjects);
  const Objects asked = more.withRules(rules);
  EXPECT_EQ(between(asked, "table", "wall"), PairReason::BothStatic);
  EXPECT_EQ(between(asked, "table", "cart"), PairReason::Checked);
  EXPECT_EQ(between(asked, "cart", "lid"), PairReason::SameBody);
  EXPECT_EQ(between(asked, "cart", "lift"), PairReason::Checked);
}

TEST_F(ObjectsOfAnArm, TwoHalfSpacesAreNotCompared) {
  ObjectRules rules;
  rules.free_objects = ObjectRules::FreeObjects::Checked;
  const Objects planes =
      none_.changed({AddObject{floorOf("floor")}, AddObject{floorOf("press", Moving{"press"})}}).withRules(rules);
  EXPECT_EQ(between(planes, "floor", "press"), PairReason::BothHalfSpaces);
}

TEST_F(ObjectsOfAnArm, ABaseThatStandsStillIsNotCheckedAgainstWhatIsFixed) {
  ObjectRules rules;
  rules.base = ObjectRules::Base::StandsStill;
  const Objects still = some_.changed({AddObject{thing("plate", Attached{"base"})}}).withRules(rules);
  EXPECT_EQ(reason(still, "base", "table"), PairReason::BothStatic);
  EXPECT_EQ(between(still, "plate", "table"), PairReason::BothStatic);
  EXPECT_EQ(reason(still, "base", "cart"), PairReason::Checked);
  EXPECT_EQ(reason(still, "arm", "table"), PairReason::Checked);
}

// --- allowed pairs

TEST(AllowedPairs, TheRuleThatWasSetLastDecides) {
  using Rule = AllowedPairs::Rule;
  AllowedPairs allowed;
  EXPECT_EQ(allowed.of("a", "b"), Rule::Checked);
  allowed.set("a", "*", Rule::Allowed);
  EXPECT_EQ(allowed.of("a", "b"), Rule::Allowed);
  EXPECT_EQ(allowed.of("b", "a"), Rule::Allowed);
  EXPECT_EQ(allowed.of("b", "c"), Rule::Checked);
  allowed.set("b", "*", Rule::Checked);
  EXPECT_EQ(allowed.of("a", "b"), Rule::Checked);
  allowed.set("b", "a", Rule::Allowed);
  EXPECT_EQ(allowed.of("a", "b"), Rule::Allowed);
  allowed.set("a", "*", Rule::Checked);
  EXPECT_EQ(allowed.of("a", "b"), Rule::Checked) << "a later rule of all others goes before an earlier one of the pair";
  allowed.set("*", "*", Rule::Allowed);
  EXPECT_EQ(allowed.of("d", "c"), Rule::Allowed);
  EXPECT_EQ(allowed.of("b", "c"), Rule::Allowed);
  EXPECT_NE(errorOf([&] { allowed.set("", "a", Rule::Allowed); }), "");
}

TEST_F(ObjectsOfAnArm, MayTouchWhatIsAllowed) {
  ObjectRules rules;
  rules.allowed.set("table", "base", AllowedPairs::Rule::Allowed);
  rules.allowed.set("bar", "*", AllowedPairs::Rule::Allowed);
  const Objects some = some_.withRules(rules);
  EXPECT_EQ(reason(some, "base", "table"), PairReason::Allowed);
  EXPECT_EQ(reason(some, "arm", "table"), PairReason::Checked);
  EXPECT_EQ(reason(some, "arm", "bar"), PairReason::Allowed);
  EXPECT_EQ(between(some, "bar", "table"), PairReason::Allowed);
}

// --- a second, plain implementation of the rules, on random scenes

/// All that the rules depend on, by name.
struct PlainScene {
  struct Thing {
    enum Kind { Fixed, Moving, Attached } kind;
    std::string carrier;  // frame or link
    std::set<std::string> touch_links;
    bool is_plane;
  };
  std::map<std::string, Thing> things;
  std::vector<std::tuple<std::string, std::string, bool>> rules;  // two names, and whether they may touch
  bool free_objects = false, base_stands_still = false;

  static std::string bodyOf(const std::string& link) { return link == "finger" ? "hand" : link; }

  bool isAllowed(const std::string& a, const std::string& b) const {
    const auto means = [](const std::string& named, const std::string& name) { return named == "*" || named == name; };
    bool allow = false;
    for (const auto& [first, second, rule] : rules)
      if ((means(first, a) && means(second, b)) || (means(first, b) && means(second, a))) allow = rule;
    return allow;
  }

  bool linkIsChecked(const std::string& link, const std::string& id) const {
    const Thing& thing = things.at(id);
    if (link == "camera" || isAllowed(link, id)) return false;
    if (thing.kind == Thing::Attached) return bodyOf(link) != bodyOf(thing.carrier) && !thing.touch_links.count(link);
    return !(thing.kind == Thing::Fixed && link == "base" && base_stands_still);
  }

  bool stands(const Thing& thing) const {
    return thing.kind == Thing::Fixed ||
           (thing.kind == Thing::Attached && thing.carrier == "base" && base_stands_still);
  }

  bool thingsAreChecked(const std::string& id_a, const std::string& id_b) const {
    const Thing &a = things.at(id_a), &b = things.at(id_b);
    if (id_a == id_b || isAllowed(id_a, id_b) || (stands(a) && stands(b)) || (a.is_plane && b.is_plane)) return false;
    if (a.kind == b.kind && a.kind != Thing::Fixed && bodyOf(a.carrier) == bodyOf(b.carrier)) return false;
    return a.kind == Thing::Attached || b.kind == Thing::Attached || free_objects;
  }
};

/// Random changes of objects and rules, each made in Objects and in the plain implementation.
class RandomChanges {
 public:
  static inline const std::vector<std::string> kLinks{"base", "arm", "hand", "finger", "camera"};

  void changeObjects(Objects& objects, PlainScene& plain) {
    std::vector<ObjectChange> changes;
    for (std::size_t change = below(4); change-- > 0;) {
      const std::string id = one(ids_);
      PlainScene::Thing thing{static_cast<PlainScene::Thing::Kind>(below(3)), "", {}, false};
      thing.is_plane = thing.kind != PlainScene::Thing::Attached && below(4) == 0;
      Placement placement = Fixed{};
      if (thing.kind == PlainScene::Thing::Moving) placement = Moving{thing.carrier = one({"f", "g"})};
      if (thing.kind == PlainScene::Thing::Attached) {
        thing.carrier = one(kLinks);
        if (below(2)) thing.touch_links.insert(one(kLinks));
        placement = Attached{thing.carrier, {thing.touch_links.begin(), thing.touch_links.end()}};
      }
      const Object object = thing.is_plane ? floorOf(id, placement) : objects_test::thing(id, placement);
      const bool is_there = plain.things.count(id) > 0;
      if (is_there && below(3) == 0) {
        changes.emplace_back(RemoveObject{id});
        plain.things.erase(id);
      } else {
        changes.push_back(is_there ? ObjectChange(ReplaceObject{object}) : ObjectChange(AddObject{object}));
        plain.things[id] = thing;
      }
    }
    objects = objects.changed(changes);
  }

  /// One time in five.
  void changeRules(Objects& objects, PlainScene& plain) {
    if (below(5) != 0) return;
    ObjectRules rules;
    plain.rules.clear();
    for (std::size_t rule = below(5); rule-- > 0;) {
      std::vector<std::string> names = ids_;
      names.insert(names.end(), kLinks.begin(), kLinks.end());
      names.insert(names.end(), 8, "*");
      const std::string a = one(names), b = one(names);
      const bool allow = below(3) > 0;
      rules.allowed.set(a, b, allow ? AllowedPairs::Rule::Allowed : AllowedPairs::Rule::Checked);
      plain.rules.emplace_back(a, b, allow);
    }
    plain.free_objects = below(2) == 0;
    plain.base_stands_still = below(2) == 0;
    if (plain.free_objects) rules.free_objects = ObjectRules::FreeObjects::Checked;
    if (plain.base_stands_still) rules.base = ObjectRules::Base::StandsStill;
    objects = objects.withRules(rules);
  }

 private:
  std::size_t below(std::size_t count) { return chance_() % count; }
  std::string one(const std::vector<std::string>& names) { return names[below(names.size())]; }

  const std::vector<std::string> ids_{"a", "b", "c", "d", "e", "f", "g", "h"};
  Chance chance_{5};
};

TEST_F(ObjectsOfAnArm, HaveThePairsThatAPlainImplementationOfTheRulesFinds) {
  RandomChanges random;
  std::map<bool, long> found;
  Objects objects = none_;
  PlainScene plain;
  for (int scene = 0; scene < 1000; ++scene) {
    random.changeObjects(objects, plain);
    random.changeRules(objects, plain);
    ASSERT_EQ(objects.size(), static_cast<int>(plain.things.size()));
    long count = 0;
    for (const auto& [id, of_id] : plain.things) {
      for (const std::string& link_name : RandomChanges::kLinks) {
        const bool expected = plain.linkIsChecked(link_name, id);
        ASSERT_EQ(reason(objects, link_name.c_str(), id) == PairReason::Checked, expected) << link_name << " " << id;
        count += expected;
        ++found[expected];
      }
      for (const auto& [other, of_other] : plain.things) {
        const bool expected = plain.thingsAreChecked(id, other);
        ASSERT_EQ(between(objects, id, other) == PairReason::Checked, expected) << id << " " << other;
        count += id < other && expected;
        ++found[expected];
      }
    }
    ASSERT_EQ(objects.pairCount(), count);
  }
  EXPECT_GT(found[true], 10000);
  EXPECT_GT(found[false], 10000);
}

}  // namespace proximity_server::scene::objects_test
