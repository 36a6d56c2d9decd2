// A small robot and a table of its joints.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <string_view>

#include "core/format/readers.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests {

// Two legs of 0.8 m. The file has the joints in another order than the tree.
inline constexpr std::string_view kBiped = R"(<robot name="biped">
  <link name="pelvis"/> <link name="l_thigh"/> <link name="l_shin"/> <link name="l_foot"/>
  <link name="r_thigh"/> <link name="r_shin"/> <link name="r_foot"/>
  <joint name="l_hip" type="revolute"><parent link="pelvis"/><child link="l_thigh"/>
    <origin xyz="0 0.1 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2"/></joint>
  <joint name="r_hip" type="revolute"><parent link="pelvis"/><child link="r_thigh"/>
    <origin xyz="0 -0.1 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2"/></joint>
  <joint name="l_knee" type="revolute"><parent link="l_thigh"/><child link="l_shin"/>
    <origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/><limit lower="0" upper="2.5"/></joint>
  <joint name="r_knee" type="revolute"><parent link="r_thigh"/><child link="r_shin"/>
    <origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/><limit lower="0" upper="2.5"/></joint>
  <joint name="l_ankle" type="fixed"><parent link="l_shin"/><child link="l_foot"/>
    <origin xyz="0 0 -0.4"/></joint>
  <joint name="r_ankle" type="fixed"><parent link="r_shin"/><child link="r_foot"/>
    <origin xyz="0 0 -0.4"/></joint>
</robot>)";

inline constexpr std::string_view kTable =
    "time_s,root_x_m,root_y_m,root_z_m,root_qx,root_qy,root_qz,root_qw,l_hip,l_knee,r_hip,r_knee\n"
    "0,1,2,0.8,0,0,0,1,0.1,0.2,0.3,0.4\n"
    "0.02,1,2,0.8,0,0,0,1,0.1,0.2,0.3,0.4\n"
    "0.04,1,2.5,0.8,0,0,0.6,0.8,0.1,0.25,0.3,0.4\n";

// Returns kTable with `from` replaced.
inline std::string TableWith(std::string_view from, std::string_view to) {
  return Replaced(std::string(kTable), from, to);
}

inline absl::StatusOr<core::MotionFile> ReadTable(std::string_view text,
                                                  std::string_view urdf = kBiped,
                                                  const core::ReadOptions& options = {}) {
  return core::ReadJointTable({.name = "walk.csv", .bytes = text},
                              core::SourceFile{.name = "robot.urdf", .bytes = urdf}, options);
}

inline std::string NotesOfTable(const absl::StatusOr<core::MotionFile>& file) {
  INFO(MessageOf(file.status()));
  REQUIRE(file.ok());
  return core::Describe(file->report);
}

}  // namespace motiondb::tests
