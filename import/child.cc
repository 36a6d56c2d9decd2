#include "import/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <new>
#include <string_view>
#include <utility>

namespace motiondb::importer {
namespace {

// Exit codes of a child without a result.
constexpr int kOutOfMemory = 3;
constexpr int kNoSandbox = 4;
constexpr int kNotWritten = 5;
constexpr int kException = 6;
// The first byte of the output of a child in the sandbox: what follows may be in the hands of its
// file.
constexpr std::string_view kEntered = "+";

bool WriteAll(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// Closes everything inherited but `output`, which becomes kOutputDescriptor: the terminal, the
// parent's requests and answers, and the pipes of other children.
bool KeepOnly(int output) {
  if (output <= kOutputDescriptor) output = fcntl(output, F_DUPFD, kOutputDescriptor + 1);
  const int nothing = open("/dev/null", O_RDWR);
  if (nothing < 0 || output < 0) return false;
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (dup2(nothing, standard) < 0) return false;
  }
  if (dup2(output, kOutputDescriptor) < 0) return false;
  return close_range(kOutputDescriptor + 1, ~0U, 0) == 0;
}

[[noreturn]] void RunChild(const std::function<std::string()>& work, const SandboxLimits& limits,
                           bool is_sandboxed, int output) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Handlers of the parent would make other system calls.
  for (const int fatal : {SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV}) signal(fatal, SIG_DFL);
  if (!KeepOnly(output)) _exit(kNoSandbox);
  // Conversions of times, as of the members of archives, then open no file of time zones.
  setenv("TZ", "UTC0", 1);
  tzset();
  if (is_sandboxed) {
    if (const absl::Status entered = EnterSandbox(limits); !entered.ok()) {
      WriteAll(kOutputDescriptor, std::string(entered.message()));
      _exit(kNoSandbox);
    }
  }
  if (!WriteAll(kOutputDescriptor, kEntered)) _exit(kNotWritten);
  try {
    _exit(WriteAll(kOutputDescriptor, work()) ? 0 : kNotWritten);
  } catch (const std::bad_alloc&) {
    _exit(kOutOfMemory);
  } catch (...) {
    _exit(kException);  // the parent's objects must not be destroyed here
  }
}

}  // namespace

bool OutputIsClosed() {
  pollfd output{STDOUT_FILENO, 0, 0};
  return poll(&output, 1, 0) > 0 && (output.revents & (POLLERR | POLLNVAL)) != 0;
}

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
      output_(std::move(other.output_)),
      was_killed_(other.was_killed_) {}

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
    return absl::UnavailableError(fmt::format("no pipe: {}", std::strerror(errno)));
  }
  const pid_t process = fork();
  if (process < 0) {
    const int error = errno;
    close(ends[0]);
    close(ends[1]);
    return absl::UnavailableError(fmt::format("no process: {}", std::strerror(error)));
  }
  if (process == 0) {
    close(ends[0]);
    RunChild(work, limits, is_sandboxed, ends[1]);
  }
  close(ends[1]);
  return Child(process, ends[0], limits);
}

bool Child::Step(bool is_readable) {
  if (IsOverdue()) return true;
  if (!is_readable) return false;
  std::array<char, 1 << 16> block;
  const ssize_t count = read(descriptor_, block.data(), block.size());
  if (count < 0 && errno == EINTR) return false;
  if (count <= 0) return true;
  output_.append(block.data(), static_cast<std::size_t>(count));
  return HasWrittenTooMuch();
}

int Child::AwaitEnd() {
  constexpr timespec kPause{0, 2'000'000};
  int status = 0;
  // It has usually ended. One that only closes its output is not waited for longer than others.
  while (!was_killed_) {
    const pid_t ended = waitpid(process_, &status, WNOHANG);
    if (ended == process_) return status;
    if (ended < 0 && errno != EINTR) break;
    if (IsOverdue() || HasWrittenTooMuch()) {
      kill(process_, SIGKILL);
      was_killed_ = true;
    } else {
      nanosleep(&kPause, nullptr);
    }
  }
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

absl::StatusOr<std::string> Child::Finish() {
  const int status = AwaitEnd();
  process_ = -1;
  const bool is_too_large = HasWrittenTooMuch();
  const bool has_entered = output_.starts_with(kEntered);
  if (has_entered) output_.erase(0, kEntered.size());
  if (is_too_large) {
    return absl::ResourceExhaustedError(
        fmt::format("the result is larger than {} MiB", limits_.result_bytes >> 20));
  }
  if (was_killed_) {
    return absl::ResourceExhaustedError(
        fmt::format("reading takes longer than {} s", 2 * limits_.cpu_seconds));
  }
  if (WIFEXITED(status)) {
    switch (WEXITSTATUS(status)) {
      case 0:
        return std::move(output_);
      case kOutOfMemory:
        return absl::ResourceExhaustedError(
            fmt::format("reading needs more than {} MiB of memory", limits_.memory_bytes >> 20));
      case kNoSandbox:
        if (!has_entered) return absl::UnavailableError(fmt::format("no sandbox: {}", output_));
        [[fallthrough]];
      default:
        return absl::InternalError(
            fmt::format("the reader failed with exit code {}", WEXITSTATUS(status)));
    }
  }
  switch (const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0) {
    case SIGXCPU:
      return absl::ResourceExhaustedError(
          fmt::format("reading needs more than {} s of processor time", limits_.cpu_seconds));
    case SIGKILL:
      return absl::ResourceExhaustedError("the reader was killed, perhaps for lack of memory");
    case SIGSYS:
      return absl::InternalError("the reader made a forbidden system call");
    default:
      return absl::InternalError(fmt::format("the reader crashed: {}", strsignal(signal)));
  }
}

}  // namespace motiondb::importer
