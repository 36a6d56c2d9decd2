#include "import/child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <vector>

namespace motiondb::tests::child_test {
namespace {

using importer::Child;

absl::StatusOr<std::string> ResultOf(const std::function<std::string()>& work,
                                     const importer::SandboxLimits& limits = {},
                                     bool is_sandboxed = true) {
  auto child = Child::Start(work, limits, is_sandboxed);
  REQUIRE(child.ok());
  bool is_over = false;
  while (!is_over) {
    pollfd ready{child->descriptor(), POLLIN, 0};
    poll(&ready, 1, 100);
    is_over = child->Step(ready.revents != 0);
  }
  return child->Finish();
}

// A value that the compiler does not know.
volatile int g_zero = 0;

TEST_CASE("Child: returns the result of its work, of any length", "[import]") {
  CHECK(ResultOf([] { return std::string("walk"); }).value() == "walk");
  CHECK(ResultOf([] { return std::string(3'000'000, 'x'); }).value().size() == 3'000'000);
  CHECK(ResultOf([] { return std::string(); }).value().empty());
}

TEST_CASE("Child: a crash ends only the child", "[import]") {
  const auto crashed = ResultOf([]() -> std::string { std::abort(); });
  CHECK(crashed.status().code() == absl::StatusCode::kInternal);
  CHECK_THAT(std::string(crashed.status().message()), Catch::StartsWith("the reader crashed"));
  CHECK(ResultOf([] { return std::string("next"); }).value() == "next");
}

TEST_CASE("Child: a child that hangs is stopped", "[import]") {
  const auto hung = ResultOf(
      []() -> std::string {
        while (g_zero == 0) {
        }
        return "";
      },
      {.cpu_seconds = 1});
  CHECK(hung.status().code() == absl::StatusCode::kResourceExhausted);
  // On a busy machine the time on the clock ends first.
  CHECK((hung.status().message() == "reading needs more than 1 s of processor time" ||
         hung.status().message() == "reading takes longer than 2 s"));
}

TEST_CASE("Child: one that waits, or writes slowly or without end, is stopped", "[import]") {
  const auto slow = ResultOf(
      []() -> std::string {
        close(importer::kOutputDescriptor);
        pause();
        return "";
      },
      {.cpu_seconds = 1}, false);
  CHECK(slow.status().message() == "reading takes longer than 2 s");
  const auto dripping = ResultOf(
      []() -> std::string {
        while (write(importer::kOutputDescriptor, "x", 1) == 1) usleep(20'000);
        return "";
      },
      {.cpu_seconds = 1}, false);
  CHECK(dripping.status().message() == "reading takes longer than 2 s");
  const auto endless = ResultOf([]() -> std::string {
    const std::string block(1 << 20, 'x');
    while (write(importer::kOutputDescriptor, block.data(), block.size()) > 0) {
    }
    return "";
  });
  CHECK(endless.status().message() == "the result is larger than 32 MiB");
}

// Sanitizers need the memory and the system calls themselves.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("Child: a child that needs too much memory is stopped", "[import]") {
  const auto work = [] {
    std::vector<std::string> blocks;
    while (g_zero == 0) blocks.emplace_back(16 << 20, 'x');
    return blocks.front();
  };
  const auto full = ResultOf(work, {.memory_bytes = 256 << 20});
  CHECK(full.status().code() == absl::StatusCode::kResourceExhausted);
  CHECK(full.status().message() == "reading needs more than 256 MiB of memory");
}

TEST_CASE("Child: cannot open files, sockets or processes in the sandbox", "[import]") {
  const pid_t parent = getpid();
  const std::vector<std::function<int()>> calls = {
      [] { return access("/etc/passwd", R_OK); },
      [] { return socket(AF_INET, SOCK_STREAM, 0); },
      [] { return static_cast<int>(fork()); },
      [=] { return kill(parent, 0); },
      [] { return system("true"); },
      [] { return dup(importer::kOutputDescriptor); },
      [] {
        return mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) ==
               MAP_FAILED;
      }};
  for (const auto& call : calls) {
    const auto work = [&] { return std::to_string(call()); };
    const auto refused = ResultOf(work);
    CHECK(refused.status().code() == absl::StatusCode::kInternal);
    CHECK(refused.status().message() == "the reader made a forbidden system call");
  }
  const auto open = [] { return std::string(access("/etc/passwd", R_OK) == 0 ? "open" : ""); };
  CHECK(ResultOf(open, {}, false).value() == "open");
}
#endif

TEST_CASE("Child: sees neither the files nor the other children of its parent", "[import]") {
  const auto other = Child::Start([] { return std::string("secret"); }, {}, true);
  REQUIRE(other.ok());
  const auto work = [] {
    std::string open;
    for (int descriptor = 0; descriptor < 256; ++descriptor) {
      char byte = 0;
      if (fcntl(descriptor, F_GETFD) < 0) continue;
      const bool has_data =
          descriptor != importer::kOutputDescriptor && read(descriptor, &byte, 1) > 0;
      open += std::to_string(descriptor) + (has_data ? " has data, " : ", ");
    }
    return open;
  };
  CHECK(ResultOf(work, {}, false).value() == "0, 1, 2, 3, ");
}

TEST_CASE("Child: ends with its object", "[import]") {
  auto child = Child::Start(
      []() -> std::string {
        while (g_zero == 0) {
        }
        return "";
      },
      {}, true);
  REQUIRE(child.ok());
  const int descriptor = dup(child->descriptor());
  { const Child gone = *std::move(child); }
  std::array<char, 8> bytes{};
  ssize_t count = 1;
  while (count > 0) count = read(descriptor, bytes.data(), bytes.size());
  CHECK(count == 0);  // its end of the pipe is closed: it has ended
  close(descriptor);
}

}  // namespace
}  // namespace motiondb::tests::child_test
