// Tables (CSV) with the robot's URDF: "<urdf>\0<table>". Without a zero byte, or if it is first,
// the table alone, such as one of points.
#include <optional>
#include <utility>

#include "core/format/readers.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/motion_properties.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto [urdf, table] = tests::SplitAtZero(tests::AsText(data, size));
  if (table.empty()) std::swap(urdf, table);
  const core::SourceFile file{"input.csv", table};
  std::optional<core::SourceFile> robot;
  if (!urdf.empty()) robot = core::SourceFile{"input.urdf", urdf};
  constexpr std::size_t kErrors = 64 << 10;
  const auto most = static_cast<std::size_t>(core::MaxBytesToReadJointTable(file, robot));
  const tests::MemoryWatch watch;
  const auto read = core::ReadJointTable(file, robot, {});
  watch.CheckProportional(most, kErrors, 1);
  tests::CheckMotionFile(read);
  return 0;
}
