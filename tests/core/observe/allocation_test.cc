// Counts the calls of this program's malloc, which operator new and Eigen use.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/observe/observer.h"
#include "tests/core/observe/point_motion.h"

namespace {

std::atomic<std::int64_t> allocations{0};

}  // namespace

// Sanitizers have their own malloc; nothing is counted there.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define MOTIONDB_COUNTS_ALLOCATIONS
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
#endif

namespace motiondb::tests::allocation_test {

#ifdef MOTIONDB_COUNTS_ALLOCATIONS
TEST_CASE("Allocations are counted", "[core][observe]") {
  const std::int64_t before = allocations;
  const core::FrameMatrix matrix(20, 20);
  const std::vector<int> numbers(20);
  CHECK(allocations - before == 2);
  CHECK(matrix.size() == 400);
  CHECK(numbers.size() == 20);
}
#endif

TEST_CASE("Observer: frames at the model's rate need no allocation after 1 s", "[core][observe]") {
  const core::Model model = PointModel(3, 3);
  const core::MarkerMotion motion = PointMotion(600, 1, 77);
  const auto observer =
      core::Observer::Create(model, PointScheme(), PointScheme().set.markers, 60, std::nullopt, {});
  REQUIRE(observer.ok());
  std::vector<core::FrameMatrix> messages;
  for (Eigen::Index t = 0; t < 600; t += 4) messages.push_back(motion.positions_m.middleRows(t, 4));
  std::int64_t frame = 0;
  std::int64_t while_warm = 0;
  for (const core::FrameMatrix& message : messages) {
    const std::int64_t before = allocations;
    const bool ok = (*observer)->Append(frame, message).ok();
    if (frame >= 120) while_warm += allocations - before;
    REQUIRE(ok);
    REQUIRE((*observer)->Answer().ok());
    frame += 4;
  }
  CHECK(while_warm == 0);
}

}  // namespace motiondb::tests::allocation_test
