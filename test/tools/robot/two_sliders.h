#pragma once

namespace proximity_server::tools {

// Three things whose distances can be worked out on paper. On the x axis:
//   base    a box from -0.5 to 0.5
//   "sled"  a box from 1.5 to 2.5, moved by the prismatic joint "slide" in -1 .. 2: distance to the base 1 + slide, so
//           in contact at -1 only
//   "ball"  a sphere of radius 0.25 about 5 + 2 * slide, carried by "follow", which mimics "slide": to the sled
//           5 + 2 s - 0.25 - (2.5 + s) = 2.25 + s
// and "mast" is fixed to the base, a sphere of radius 0.5 about (0, 4, 0): farther from the others than they
// are from each other.
inline const char* const kTwoSliders = R"(<robot name="two sliders">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="mast"><collision><geometry><sphere radius="0.5"/></geometry></collision></link>
  <link name="sled, left"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="ball"><collision><geometry><sphere radius="0.25"/></geometry></collision></link>
  <joint name="weld" type="fixed">
    <parent link="base"/><child link="mast"/><origin xyz="0 4 0"/></joint>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="sled, left"/><origin xyz="2 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
  <joint name="follow" type="prismatic">
    <parent link="base"/><child link="ball"/><origin xyz="5 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="4" effort="1" velocity="1"/><mimic joint="slide" multiplier="2"/></joint>
</robot>)";

}  // namespace proximity_server::tools
