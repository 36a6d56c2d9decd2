#include "client/input_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/client/temporary_folder.h"

namespace motiondb::tests::input_file_test {
namespace {

using Catch::Contains;
using client::InputFile;
using client::ReadWholeFile;

TEST_CASE("ReadWholeFile: reads all bytes up to the limit", "[client]") {
  const TemporaryFolder folder;
  const std::string bytes((2 << 20) + 17, 'x');
  const auto path = folder.Write("file", bytes);
  CHECK(*ReadWholeFile(path, bytes.size()) == bytes);
  CHECK(*ReadWholeFile(folder.Write("empty", ""), 0) == "");
  const absl::Status too_large = ReadWholeFile(path, 2 << 20).status();
  CHECK(too_large.code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(too_large.message()), Contains(path.string() + ": is larger than 2 MiB"));
  // Files without a size are limited by the bytes that were read.
  CHECK(ReadWholeFile("/proc/self/status", 1 << 20)->rfind("Name:", 0) == 0);
  CHECK_THAT(std::string(ReadWholeFile("/dev/zero", 64 << 10).status().message()),
             Contains("/dev/zero: is larger than 64 KiB"));
}

TEST_CASE("InputFile: errors contain the reason", "[client]") {
  const TemporaryFolder folder;
  const auto message = [](const std::filesystem::path& path) {
    return std::string(InputFile::Open(path).status().message());
  };
  CHECK(InputFile::Open(folder / "none").status().code() == absl::StatusCode::kNotFound);
  CHECK_THAT(message(folder / "none"), Contains("none: no such file"));
  CHECK_THAT(message(folder.path()), Contains("is a folder, not a file"));
  const auto plain = folder.Write("plain", "text");
  CHECK_THAT(message(plain / "inner"), Contains("inner: cannot be read: Not a directory"));
  std::filesystem::create_symlink("loop", folder / "loop");
  CHECK_THAT(message(folder / "loop"), Contains("loop: cannot be read: Too many levels"));
  if (geteuid() != 0) {  // root may read everything
    chmod(plain.c_str(), 0);
    CHECK_THAT(message(plain), Contains("plain: cannot be read: Permission denied"));
  }
  // A file that can be opened but not read.
  auto memory = InputFile::Open("/proc/self/mem");
  REQUIRE(memory.ok());
  std::string block;
  CHECK_THAT(std::string(memory->Read(16, block).message()),
             Contains("/proc/self/mem: cannot be read: Input/output error"));
}

}  // namespace
}  // namespace motiondb::tests::input_file_test
