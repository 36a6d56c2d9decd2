#include "import/sandbox.h"

#include <fmt/format.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace motiondb::importer {
namespace {

absl::Status SystemError(const char* what, int error) {
  return absl::InternalError(fmt::format("{}: {}", what, std::strerror(error)));
}

absl::Status Limit(int resource, rlim_t most, rlim_t kills_at) {
  const rlimit limit{most, kills_at};
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

class Filter {
 public:
  bool is_made() const { return filter_ != nullptr; }

  template <typename... Conditions>
  void Allow(int call, Conditions... conditions) {
    const int error =
        seccomp_rule_add(filter_.get(), SCMP_ACT_ALLOW, call, sizeof...(conditions), conditions...);
    if (error_ == 0) error_ = error;
  }

  absl::Status Load() {
    if (error_ == 0) error_ = seccomp_load(filter_.get());
    return error_ == 0 ? absl::OkStatus() : SystemError("seccomp", -error_);
  }

 private:
  const std::unique_ptr<void, decltype(&seccomp_release)> filter_{
      seccomp_init(SCMP_ACT_KILL_PROCESS), &seccomp_release};
  int error_ = 0;
};

absl::Status AllowOnlyComputing() {
  Filter filter;
  if (!filter.is_made()) return absl::InternalError("seccomp is not available");
  // Memory, time, the signals of a failed assertion, and the end of the process.
  for (const int call :
       {SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise), SCMP_SYS(futex),
        SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday), SCMP_SYS(getrandom), SCMP_SYS(getpid),
        SCMP_SYS(gettid), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigreturn),
        SCMP_SYS(sigaltstack), SCMP_SYS(sched_yield), SCMP_SYS(exit), SCMP_SYS(exit_group)}) {
    filter.Allow(call);
  }
  filter.Allow(SCMP_SYS(mmap), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  filter.Allow(SCMP_SYS(mprotect), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  filter.Allow(SCMP_SYS(write), SCMP_A0(SCMP_CMP_EQ, kOutputDescriptor));
  filter.Allow(SCMP_SYS(write), SCMP_A0(SCMP_CMP_EQ, STDERR_FILENO));
  // abort() signals its own process.
  filter.Allow(SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid())));
  return filter.Load();
}

}  // namespace

absl::Status EnterSandbox(const SandboxLimits& limits) {
  if (prctl(PR_SET_DUMPABLE, 0) != 0) return SystemError("prctl", errno);
  absl::Status status = Limit(RLIMIT_CORE, 0, 0);
  if (status.ok()) status = Limit(RLIMIT_FSIZE, 0, 0);
  const auto seconds = static_cast<rlim_t>(limits.cpu_seconds);
  if (status.ok()) status = Limit(RLIMIT_CPU, seconds, seconds + 1);
  if (kHasSanitizer || !status.ok()) return status;
  const auto bytes = static_cast<rlim_t>(limits.memory_bytes);
  status = Limit(RLIMIT_AS, bytes, bytes);
  return status.ok() ? AllowOnlyComputing() : status;
}

}  // namespace motiondb::importer
