// URDF files of robots.
#include <cmath>

#include "core/export/writers.h"
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
  // A motion of a robot at rest can be written.
  core::JointMotion still{.skeleton = std::make_shared<const core::Skeleton>(read->skeleton),
                          .frame_rate_hz = 60,
                          .angles = core::JointMatrix::Zero(2, read->skeleton.dof_count())};
  const auto table = core::WriteJointTable(still, read->mimics);
  tests::CheckErrorContract(table.status(), absl::StatusCode::kInvalidArgument);
  return 0;
}
