#include "import/child.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

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
  while (true) {
    pollfd ready{child->descriptor(), POLLIN, 0};
    poll(&ready, 1, 100);
    if (ready.revents != 0 ? !child->Read() : child->IsOverdue()) return child->Finish();
  }
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
  CHECK(hung.status().message() == "reading takes longer than 1 s");
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
  const std::vector<std::function<int()>> calls = {
      [] { return access("/etc/passwd", R_OK); }, [] { return socket(AF_INET, SOCK_STREAM, 0); },
      [] { return static_cast<int>(fork()); }, [] { return kill(getppid(), 0); },
      [] { return system("true"); }};
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

TEST_CASE("Child: does not see the requests of its parent", "[import]") {
  const auto work = [] {
    char byte = 0;
    return std::string(read(STDIN_FILENO, &byte, 1) < 0 ? "closed" : "open");
  };
  CHECK(ResultOf(work).value() == "closed");
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
  char byte = 0;
  CHECK(read(descriptor, &byte, 1) == 0);  // its end of the pipe is closed: it has ended
  close(descriptor);
}

}  // namespace
}  // namespace motiondb::tests::child_test
