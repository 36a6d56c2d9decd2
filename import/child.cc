#include "import/child.h"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <new>
#include <string_view>
#include <utility>

namespace motiondb::importer {
namespace {

// Exit codes of a child without a result.
constexpr int kOutOfMemory = 3;
constexpr int kNoSandbox = 4;
constexpr int kNotWritten = 5;

bool WriteAll(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

[[noreturn]] void RunChild(const std::function<std::string()>& work, const SandboxLimits& limits,
                           bool is_sandboxed, int descriptor) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Handlers of the parent would make other system calls.
  for (const int fatal : {SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV}) signal(fatal, SIG_DFL);
  close(STDIN_FILENO);  // the parent's requests and answers
  close(STDOUT_FILENO);
  if (is_sandboxed) {
    if (const absl::Status entered = EnterSandbox(limits); !entered.ok()) {
      WriteAll(descriptor, std::string(entered.message()));
      _exit(kNoSandbox);
    }
  }
  try {
    _exit(WriteAll(descriptor, work()) ? 0 : kNotWritten);
  } catch (const std::bad_alloc&) {
    _exit(kOutOfMemory);
  }
}

}  // namespace

Child::Child(pid_t process, int descriptor, const SandboxLimits& limits)
    : process_(process),
      descriptor_(descriptor),
      limits_(limits),
      // Waiting does not count as processor time.
      deadline_(std::chrono::steady_clock::now() + std::chrono::seconds(2 * limits.cpu_seconds)) {}

Child::Child(Child&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      limits_(other.limits_),
      deadline_(other.deadline_),
      output_(std::move(other.output_)) {}

Child::~Child() {
  if (descriptor_ >= 0) close(descriptor_);
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

absl::StatusOr<Child> Child::Start(const std::function<std::string()>& work,
                                   const SandboxLimits& limits, bool is_sandboxed) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) {
    return absl::InternalError(fmt::format("no pipe: {}", std::strerror(errno)));
  }
  const pid_t process = fork();
  if (process < 0) {
    const int error = errno;
    close(ends[0]);
    close(ends[1]);
    return absl::InternalError(fmt::format("no process: {}", std::strerror(error)));
  }
  if (process == 0) {
    close(ends[0]);
    RunChild(work, limits, is_sandboxed, ends[1]);
  }
  close(ends[1]);
  return Child(process, ends[0], limits);
}

bool Child::Read() {
  std::array<char, 1 << 16> block;
  const ssize_t count = read(descriptor_, block.data(), block.size());
  if (count < 0 && errno == EINTR) return true;
  if (count <= 0) return false;
  output_.append(block.data(), static_cast<std::size_t>(count));
  return true;
}

absl::StatusOr<std::string> Child::Finish() {
  const bool is_overdue = IsOverdue();
  if (is_overdue) kill(process_, SIGKILL);
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  const auto out_of_memory = [&] {
    return absl::ResourceExhaustedError(
        fmt::format("reading needs more than {} MiB of memory", limits_.memory_bytes >> 20));
  };
  if (WIFEXITED(status)) {
    switch (WEXITSTATUS(status)) {
      case 0:
        return std::move(output_);
      case kOutOfMemory:
        return out_of_memory();
      case kNoSandbox:
        return absl::InternalError(fmt::format("no sandbox: {}", output_));
      default:
        return absl::InternalError(
            fmt::format("the reader failed with exit code {}", WEXITSTATUS(status)));
    }
  }
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (is_overdue || signal == SIGXCPU || signal == SIGKILL) {
    return absl::ResourceExhaustedError(
        fmt::format("reading takes longer than {} s", limits_.cpu_seconds));
  }
  if (signal == SIGSYS) return absl::InternalError("the reader made a forbidden system call");
  return absl::InternalError(
      fmt::format("the reader crashed: {}", signal != 0 ? strsignal(signal) : "unknown reason"));
}

}  // namespace motiondb::importer
