// A URDF file with all features, and helpers to read it.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <string_view>

#include "core/format/urdf_reader.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests {

// Every type of joint, children before their parents, and elements that a reader ignores.
inline constexpr std::string_view kRobot = R"(<?xml version="1.0"?>
<!-- A robot > with everything. -->
<robot name="odd">
  <material name="grey"><color rgba="1 1 1 1"/></material>
  <joint name="elbow" type="revolute">
    <parent link="upper"/>
    <child link="lower"/>
    <origin xyz="0 0 -0.3" rpy="0 0 1.5707963267948966"/>
    <axis xyz="0 2 0"/>
    <limit lower="-0.5" upper="2" effort="1" velocity="1"/>
  </joint>
  <joint name="shoulder" type="continuous">
    <origin xyz="0 0.2 0.4"/>
    <parent link="base"/>
    <child link="upper"/>
  </joint>
  <link name="base"><inertial><mass value="1"/></inertial></link>
  <link name="upper"/>
  <link name="lower"/>
  <link name="rail"/>
  <link name="finger"/>
  <link name="thumb"/>
  <link name="tip"/>
  <link name="puck"/>
  <link name="kite"/>
  <joint name="slide" type="prismatic">
    <parent link="lower"/>
    <child link="rail"/>
    <origin rpy="0 1.5707963267948966 0" xyz="1 0 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="0" upper="0.1" effort="1" velocity="1"/>
  </joint>
  <joint name="finger" type="revolute">
    <parent link="rail"/>
    <child link="finger"/>
    <axis xyz="0 0 1"/>
    <limit effort="1" velocity="1" upper="1"/>
    <mimic joint="elbow" multiplier="2" offset="0.25"/>
  </joint>
  <joint name="thumb" type="prismatic">
    <parent link="rail"/>
    <child link="thumb"/>
    <axis xyz="0 1 0"/>
    <limit effort="1" velocity="1" upper="1"/>
    <mimic joint="finger" multiplier="-3" offset="1"/>
  </joint>
  <joint name="tip_joint" type="fixed">
    <parent link="finger"/>
    <child link="tip"/>
    <axis xyz="0 0 0"/>
  </joint>
  <joint name="puck" type="planar">
    <parent link="base"/>
    <child link="puck"/>
    <axis xyz="0 0 -1"/>
  </joint>
  <joint name="kite" type="floating">
    <parent link="base"/>
    <child link="kite"/>
  </joint>
  <transmission name="t"><joint name="elbow"/></transmission>
</robot>
)";

inline absl::StatusOr<core::UrdfRobot> ReadRobot(std::string_view text) {
  return core::ReadUrdf({.name = "robot.urdf", .bytes = text});
}

inline core::UrdfRobot GoodRobot(std::string_view text) {
  auto robot = ReadRobot(text);
  INFO(MessageOf(robot.status()));
  REQUIRE(robot.ok());
  return *std::move(robot);
}

// Returns the refusal of kRobot with `from` replaced.
inline std::string ErrorMessageWith(std::string_view from, std::string_view to) {
  return ErrorMessageOf(ReadRobot(Replaced(std::string(kRobot), from, to)));
}

}  // namespace motiondb::tests
