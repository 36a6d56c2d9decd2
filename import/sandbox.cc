#include "import/sandbox.h"

#include <fmt/format.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>

namespace motiondb::importer {
namespace {

absl::Status SystemError(const char* what, int error) {
  return absl::InternalError(fmt::format("{}: {}", what, std::strerror(error)));
}

absl::Status Limit(int resource, rlim_t most) {
  const rlimit limit{most, most};
  if (setrlimit(static_cast<__rlimit_resource>(resource), &limit) == 0) return absl::OkStatus();
  return SystemError("setrlimit", errno);
}

// Address sanitizers reserve terabytes of address space.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kHasSanitizer = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
constexpr bool kHasSanitizer = true;
#else
constexpr bool kHasSanitizer = false;
#endif
#else
constexpr bool kHasSanitizer = false;
#endif

absl::Status AllowOnlyComputing() {
  // Memory, open files, time, signals of a failed assertion, and the end of the process.
  constexpr std::array kAllowed = {
      SCMP_SYS(brk),           SCMP_SYS(mmap),         SCMP_SYS(munmap),
      SCMP_SYS(mremap),        SCMP_SYS(mprotect),     SCMP_SYS(madvise),
      SCMP_SYS(read),          SCMP_SYS(pread64),      SCMP_SYS(write),
      SCMP_SYS(writev),        SCMP_SYS(close),        SCMP_SYS(lseek),
      SCMP_SYS(fstat),         SCMP_SYS(newfstatat),   SCMP_SYS(futex),
      SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday), SCMP_SYS(getrandom),
      SCMP_SYS(getpid),        SCMP_SYS(gettid),       SCMP_SYS(rt_sigprocmask),
      SCMP_SYS(rt_sigaction),  SCMP_SYS(rt_sigreturn), SCMP_SYS(sigaltstack),
      SCMP_SYS(sched_yield),   SCMP_SYS(exit),         SCMP_SYS(exit_group)};
  const std::unique_ptr<void, decltype(&seccomp_release)> filter(
      seccomp_init(SCMP_ACT_KILL_PROCESS), &seccomp_release);
  if (filter == nullptr) return SystemError("seccomp_init", ENOMEM);
  for (const int call : kAllowed) {
    const int error = seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0);
    if (error != 0) return SystemError("seccomp_rule_add", -error);
  }
  // abort() signals its own process.
  int error = seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1,
                               SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid())));
  if (error != 0) return SystemError("seccomp_rule_add", -error);
  error = seccomp_load(filter.get());
  return error == 0 ? absl::OkStatus() : SystemError("seccomp_load", -error);
}

}  // namespace

absl::Status EnterSandbox(const SandboxLimits& limits) {
  if (prctl(PR_SET_DUMPABLE, 0) != 0) return SystemError("prctl", errno);
  absl::Status status = Limit(RLIMIT_CORE, 0);
  if (status.ok()) status = Limit(RLIMIT_FSIZE, 0);
  if (status.ok()) status = Limit(RLIMIT_CPU, static_cast<rlim_t>(limits.cpu_seconds));
  if (kHasSanitizer || !status.ok()) return status;
  status = Limit(RLIMIT_AS, static_cast<rlim_t>(limits.memory_bytes));
  return status.ok() ? AllowOnlyComputing() : status;
}

}  // namespace motiondb::importer
