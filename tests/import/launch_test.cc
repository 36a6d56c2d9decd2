// How other programs run motiondb-import. Small system programs stand in for it.
#include "import/launch.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace motiondb::tests::launch_test {
namespace {

using importer::ImportCall;
using LaunchClock = std::chrono::steady_clock;

// Runs `program` instead of motiondb-import and returns its output.
absl::StatusOr<std::string> OutputOf(const char* program, const ImportCall& call) {
  const char* const before = std::getenv("MOTIONDB_IMPORT");
  const std::string restored = before == nullptr ? "" : before;
  setenv("MOTIONDB_IMPORT", program, 1);
  std::string output;
  const absl::Status status = importer::RunImportProgram(call, [&](std::string_view block) {
    output += block;
    return absl::OkStatus();
  });
  if (before == nullptr) {
    unsetenv("MOTIONDB_IMPORT");
  } else {
    setenv("MOTIONDB_IMPORT", restored.c_str(), 1);
  }
  if (!status.ok()) return status;
  return output;
}

// Whether this process has a child, also one that has ended and was not waited for.
bool HasChild() { return !(waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD); }

}  // namespace

TEST_CASE("RunImportProgram: the program inherits only its files", "[import]") {
  // Open files without O_CLOEXEC, below and above the numbers that the program gets.
  std::vector<int> open_here;
  std::array<int, 2> sockets{};
  REQUIRE(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()) == 0);
  open_here.insert(open_here.end(), sockets.begin(), sockets.end());
  for (int i = 0; i < 30; ++i) open_here.push_back(open("/dev/null", O_RDONLY));
  for (const int number : {100, 500}) open_here.push_back(fcntl(sockets[0], F_DUPFD, number));
  const auto listed =
      OutputOf("/bin/ls", {.arguments = {"-l", "/proc/self/fd"}, .files = {sockets[0]}});
  for (const int descriptor : open_here) close(descriptor);
  REQUIRE(listed.ok());
  INFO(*listed);
  std::set<std::string> inherited;
  std::istringstream lines(*listed);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t arrow = line.find(" -> ");
    if (arrow == line.npos) continue;
    const std::string target = line.substr(arrow + 4);
    if (target.starts_with("/proc/")) continue;  // the folder that ls itself reads
    inherited.insert(
        line.substr(line.rfind(' ', arrow - 1) + 1, arrow - line.rfind(' ', arrow - 1) - 1));
  }
  CHECK(inherited == std::set<std::string>{"0", "1", "2", "10"});
  CHECK_FALSE(HasChild());
}

TEST_CASE("RunImportProgram: the environment of this program stays here", "[import]") {
  setenv("MOTIONDB_SECRET", "mdb_secret", 1);
  const auto environment = OutputOf("/usr/bin/env", {.arguments = {}});
  unsetenv("MOTIONDB_SECRET");
  REQUIRE(environment.ok());
  CHECK(environment->find("SECRET") == environment->npos);
}

TEST_CASE("RunImportProgram: a cancelled or late program ends, and nothing is left of it",
          "[import]") {
  const auto begin = LaunchClock::now();
  const auto cancelled = [&] {
    return LaunchClock::now() - begin > std::chrono::milliseconds(100);
  };
  const auto stopped = OutputOf("/bin/sleep", {.arguments = {"60"}, .cancelled = cancelled});
  CHECK(absl::IsCancelled(stopped.status()));
  CHECK_FALSE(HasChild());
  const auto late =
      OutputOf("/bin/sleep", {.arguments = {"60"}, .timeout = std::chrono::seconds(1)});
  CHECK(absl::IsDeadlineExceeded(late.status()));
  CHECK_FALSE(HasChild());
  // One that ignores the request to end is killed.
  const auto stubborn = OutputOf(
      "/bin/sh",
      {.arguments = {"-c", "trap '' TERM; while :; do sleep 0.1; done"}, .cancelled = cancelled});
  CHECK(absl::IsCancelled(stubborn.status()));
  CHECK_FALSE(HasChild());
  CHECK(LaunchClock::now() - begin < std::chrono::seconds(40));
}

TEST_CASE("RunImportProgram: many calls leave no open file and no process", "[import]") {
  const auto open_files = [] {
    int count = 0;
    for (int descriptor = 0; descriptor < 1024; ++descriptor) {
      if (fcntl(descriptor, F_GETFD) >= 0) ++count;
    }
    return count;
  };
  const int before = open_files();
  std::vector<std::jthread> callers;
  for (int caller = 0; caller < 4; ++caller) {
    callers.emplace_back([] {
      for (int i = 0; i < 20; ++i) {
        importer::RunImportProgram({.arguments = {}}, [](std::string_view) {
          return absl::OkStatus();
        }).IgnoreError();
      }
    });
  }
  callers.clear();
  CHECK(open_files() == before);
  CHECK_FALSE(HasChild());
}

}  // namespace motiondb::tests::launch_test
