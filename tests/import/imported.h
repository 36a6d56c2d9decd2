// Reads files as motiondb-import does, and looks at the motion.
#pragma once

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cstddef>
#include <string>
#include <string_view>

#include "core/motion/forward_kinematics.h"
#include "import/npz/npz_reader.h"
#include "import/scene/scene_reader.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests {

// Reads a NumPy archive with the name "walk.npz".
inline absl::StatusOr<core::MotionFile> ReadNpzBytes(const std::string& bytes,
                                                     const core::ReadOptions& options = {},
                                                     std::size_t limit = 100'000'000) {
  return importer::ReadNpz({.name = "walk.npz", .bytes = bytes}, options, limit);
}

// Reads a scene with the name "walk.glb", "walk.fbx" or "walk.dae".
inline absl::StatusOr<core::MotionFile> ReadSceneBytes(core::FileFormat format,
                                                       std::string_view bytes,
                                                       const core::ReadOptions& options = {}) {
  const std::string_view name = format == core::FileFormat::kFbx    ? "walk.fbx"
                                : format == core::FileFormat::kGltf ? "walk.glb"
                                                                    : "walk.dae";
  return importer::ReadScene(format, {.name = name, .bytes = bytes}, options);
}

// Returns the report of a file that was read, as one line.
inline std::string NotesOf(const absl::StatusOr<core::MotionFile>& file) {
  INFO(MessageOf(file.status()));
  REQUIRE(file.ok());
  return core::Describe(file->report);
}

// Returns the position of a joint in the world, m.
inline Eigen::Vector3d PositionOf(const core::JointMotion& motion, std::string_view joint,
                                  Eigen::Index frame) {
  const int index = motion.skeleton->FindJoint(joint);
  REQUIRE(index >= 0);
  return core::JointPositions(motion).block<1, 3>(frame, 3 * index).transpose().cast<double>();
}

inline bool Near(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance = 1e-5) {
  return (a - b).norm() < tolerance;
}

// Returns the greatest change of an angle from frame to frame.
inline double MaxStep(const core::JointMatrix& angles) {
  return (angles.bottomRows(angles.rows() - 1) - angles.topRows(angles.rows() - 1))
      .cwiseAbs()
      .maxCoeff();
}

}  // namespace motiondb::tests
