// BVH files.
#include "core/format/readers.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/motion_properties.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const tests::MemoryWatch watch;
  const auto read = core::ReadBvh({"input.bvh", tests::AsText(data, size)}, {});
  watch.CheckProportional(size, 1 << 20, 200);
  tests::CheckMotionFile(read);
  return 0;
}
