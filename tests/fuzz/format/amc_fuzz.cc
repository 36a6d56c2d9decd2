// ASF files with their AMC files: "<asf>\0<amc>".
#include "core/format/readers.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/motion_properties.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto [asf, amc] = tests::SplitAtZero(tests::AsText(data, size));
  const tests::MemoryWatch watch;
  const auto read = core::ReadAmc({"input.amc", amc}, {"input.asf", asf}, {});
  watch.CheckProportional(size, 1 << 20, 200);
  tests::CheckMotionFile(read);
  return 0;
}
