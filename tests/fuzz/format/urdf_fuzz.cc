// URDF files of robots.
#include <cmath>

#include "core/export/writers.h"
#include "core/format/urdf_elements.h"
#include "core/format/urdf_reader.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/motion_properties.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const tests::MemoryWatch watch;
  const auto read = core::ReadUrdf({"input.urdf", tests::AsText(data, size)});
  watch.CheckProportional(size, 1 << 20, 200);
  tests::CheckErrorContract(read.status(), absl::StatusCode::kInvalidArgument);
  if (!read.ok()) return 0;

  tests::CheckContract(read->skeleton.dof_count() >= 6, "a robot has a floating base");
  for (const core::MimicJoint& mimic : read->mimics) {
    tests::CheckContract(read->skeleton.FindJoint(mimic.joint) >= 0, "a mimic joint is a joint");
    tests::CheckContract(read->skeleton.FindJoint(mimic.master) >= 0,
                         "the master of a mimic joint is a joint");
    tests::CheckContract(std::isfinite(mimic.multiplier) && std::isfinite(mimic.offset),
                         "multiplier and offset are finite");
  }
  tests::CheckContract(read->visuals.size() <= core::kMaxVisuals, "few visual shapes");
  for (const core::LinkVisual& visual : read->visuals) {
    tests::CheckContract(visual.joint >= 0 && visual.joint < read->skeleton.joint_count(),
                         "the joint of a visual shape exists");
    tests::CheckContract(visual.size_m.minCoeff() > 0 &&
                             visual.size_m.maxCoeff() <= core::kMaxVisualLength_m &&
                             visual.joint_from_shape.matrix().allFinite(),
                         "size and pose of a visual shape are in range");
    tests::CheckContract(
        !visual.color || (visual.color->minCoeff() >= 0 && visual.color->maxCoeff() <= 1),
        "the colour of a visual shape is in range");
  }
  // A motion of a robot at rest can be written.
  core::JointMotion still{.skeleton = std::make_shared<const core::Skeleton>(read->skeleton),
                          .frame_rate_hz = 60,
                          .angles = core::JointMatrix::Zero(2, read->skeleton.dof_count())};
  const auto table = core::WriteJointTable(still, read->mimics);
  tests::CheckErrorContract(table.status(), absl::StatusCode::kInvalidArgument);
  return 0;
}
