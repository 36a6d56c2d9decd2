#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "server/settings/process_limits.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::memory_limit_test {
namespace {

class FakeRoot {
 public:
  void Write(const std::string& file, const std::string& text) {
    const std::filesystem::path path = directory_ / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  std::int64_t Limit() { return server::MemoryLimit(directory_ / ""); }

 private:
  TemporaryDirectory directory_;
};

TEST_CASE("MemoryLimit: the machine's memory if no control group limits it", "[settings]") {
  FakeRoot root;
  const std::int64_t machine = root.Limit();
  CHECK(machine > std::int64_t{64} << 20);
  root.Write("proc/self/cgroup", "0::/service\n");
  root.Write("sys/fs/cgroup/service/memory.max", "max\n");
  CHECK(root.Limit() == machine);
}

TEST_CASE("MemoryLimit: the minimum of a control group and its parents", "[settings]") {
  FakeRoot root;
  SECTION("version 2") {
    root.Write("proc/self/cgroup", "0::/outer/inner\n");
    root.Write("sys/fs/cgroup/outer/inner/memory.max", "2000000\n");
    CHECK(root.Limit() == 2'000'000);
    root.Write("sys/fs/cgroup/outer/memory.max", "1000000\n");
    CHECK(root.Limit() == 1'000'000);
  }
  SECTION("version 1") {
    root.Write("proc/self/cgroup", "5:cpu:/\n4:memory:/job\n0::/\n");
    root.Write("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "3000000\n");
    CHECK(root.Limit() == 3'000'000);
  }
  SECTION("a container that sees its own group as the root") {
    root.Write("proc/self/cgroup", "0::/kubepods/pod\n");
    root.Write("sys/fs/cgroup/memory.max", "4000000\n");
    CHECK(root.Limit() == 4'000'000);
  }
}

}  // namespace
}  // namespace motiondb::tests::memory_limit_test
