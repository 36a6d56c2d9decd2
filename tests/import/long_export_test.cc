// Long clips are written within the limits of motiondb-import.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

#include "core/export/motion_writer.h"
#include "import/child.h"

// Sanitizers need memory themselves.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace motiondb::tests::long_export_test {
namespace {

core::MarkerMotion LongMotion(int frames, int markers) {
  core::MarkerMotion motion{{}, 120, core::FrameMatrix(frames, 3 * markers)};
  for (int m = 0; m < markers; ++m) motion.names.push_back("marker" + std::to_string(m));
  for (int frame = 0; frame < frames; ++frame) {
    const float phase = 0.01F * static_cast<float>(frame);
    for (int column = 0; column < motion.positions_m.cols(); ++column) {
      motion.positions_m(frame, column) = std::sin(phase + static_cast<float>(column));
    }
  }
  return motion;
}

// Address space of this process, which the child inherits from the other tests.
std::int64_t UsedBytes() {
  std::int64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * sysconf(_SC_PAGESIZE);
}

}  // namespace

TEST_CASE("WriteMotion: 40 minutes at 120 Hz are written within 512 MiB", "[import]") {
  constexpr int kFrames = 300'000;
  const core::MarkerMotion motion = LongMotion(kFrames, 10);
  for (const core::FormatInfo& info : core::KnownFormats()) {
    if (!info.is_written) continue;
    CAPTURE(info.name);
    const auto work = [&] {
      const auto written = core::WriteMotion(info.format, motion);
      return written.ok() ? std::to_string(written->bytes.size())
                          : std::string(written.status().message());
    };
    auto child = importer::Child::Start(
        work, {.memory_bytes = UsedBytes() + (std::int64_t{512} << 20), .cpu_seconds = 120}, true);
    REQUIRE(child.ok());
    while (!child->Step(true)) {
    }
    const auto result = child->Finish();
    INFO(result.status());
    REQUIRE(result.ok());
    INFO(*result);
    CHECK(std::atoll(result->c_str()) > std::int64_t{kFrames} * 10 * 3 * 4);
  }
}

}  // namespace motiondb::tests::long_export_test
#endif
