#pragma once

#include "proximity_server/scene/loading/load_robot_model.h"
#include "sanitized.h"
#include "tools/pair_audit/pair_study.h"

namespace proximity_server::tools {

using namespace scene;

// A robot whose pairs are in the class that paper says. s is the position of "slide", and so on.
//   base   a box from -0.5 to 0.5
//   cart   a sphere of radius 0.1 about (s, 5, 0), s in 0 .. 2: the joint that carries all of the following but "loose"
//   far    a sphere of radius 0.25 about (4 + s + reach, 0, 0), reach in 0 .. 2: 3.25 + s + reach from the base
//   rod    a box 6 x 0.2 x 0.2 about (s, 0, 0) that spins about x: always through the base; at least 0.75 from far
//   tip    a sphere of radius 0.25 about (s, 3 - approach, 0), approach in 0 .. 2.25: touches the base only at the very
//          end of "approach", where s <= 0.5; apart from the rod, which reaches to sqrt(0.02) from its axis
//   loose  a sphere of radius 1 about (0, 0, 20), on a floating joint: nobody knows
// Neighbours are base - cart, base - loose, and cart with far, rod and tip.
inline const char* const kCrossingSliders = R"(<robot name="crossing sliders">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="cart"><collision><origin xyz="0 5 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="far"><collision><geometry><sphere radius="0.25"/></geometry></collision></link>
  <link name="rod"><collision><geometry><box size="6 0.2 0.2"/></geometry></collision></link>
  <link name="tip"><collision><geometry><sphere radius="0.25"/></geometry></collision></link>
  <link name="loose"><collision><geometry><sphere radius="1"/></geometry></collision></link>
  <link name="camera"/>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="2" effort="1" velocity="1"/></joint>
  <joint name="reach" type="prismatic">
    <parent link="cart"/><child link="far"/><origin xyz="4 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="2" effort="1" velocity="1"/></joint>
  <joint name="spin" type="continuous"><parent link="cart"/><child link="rod"/><axis xyz="1 0 0"/></joint>
  <joint name="approach" type="prismatic">
    <parent link="cart"/><child link="tip"/><origin xyz="0 3 0"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="2.25" effort="1" velocity="1"/></joint>
  <joint name="drift" type="floating"><parent link="base"/><child link="loose"/><origin xyz="0 0 20"/></joint>
  <joint name="mount" type="fixed"><parent link="base"/><child link="camera"/></joint>
</robot>)";

// Dangerous is base - tip; useless work is what it leaves checked: rod - far and tip - far; base - rod always alarms.
inline const char* const kFaultySrdf = R"(<robot name="crossing sliders">
  <!-- what moves -->
  <group name="all"><chain base_link="base" tip_link="far"/></group>
  <disable_collisions link1="tip" link2="base" reason="User"/>
  <disable_collisions link1="base" link2="far" reason="Never"/>
  <disable_collisions link1="rod" link2="tip" reason="Never"/>
  <disable_collisions link1="tip" link2="rod" reason="Never"/>
  <disable_collisions link1="base" link2="camera" reason="Adjacent"/>
  <disable_collisions link1="base" link2="raod" reason="Never"/>
  <group_state name="home" group="all"><joint name="slide" value="0"/></group_state>
</robot>)";

/// As many states as a study of this robot takes to its end, of which a sanitizer gets a part: each is the same code.
inline StudyOptions studyOptions() {
  StudyOptions options;
  if (kIsSanitized) options.most_samples = 2000;
  return options;
}

/// The study of every pair, made once for all tests.
struct CrossingSlidersStudy {
  std::shared_ptr<const SceneModel> model = [] {
    auto made = std::make_shared<SceneModel>();
    made->robot = loadRobotModel(kCrossingSliders, packageResolver({}));
    made->pairs = filterPairs(made->robot, "");
    return made;
  }();
  PairStudy study = studyPairs(model, studyOptions());
};
inline const CrossingSlidersStudy& crossingSlidersStudy() {
  static const CrossingSlidersStudy once;
  return once;
}

}  // namespace proximity_server::tools
