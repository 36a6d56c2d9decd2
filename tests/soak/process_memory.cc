#include "tests/soak/process_memory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace motiondb::tests {
namespace {

std::int64_t StatusBytes(pid_t process, const std::string& key) {
  std::ifstream status(fmt::format("/proc/{}/status", process));
  std::string word;
  while (status >> word) {
    std::int64_t kilobytes = 0;
    if (word == key && status >> kilobytes) return kilobytes * 1024;
  }
  throw std::runtime_error(fmt::format("process {} has ended", process));
}

void Write(const std::string& file, const std::string& text) {
  std::ofstream to(file);
  to << text << std::flush;
  if (!to) throw std::runtime_error("cannot write to " + file);
}

}  // namespace

std::int64_t ResidentMemory(pid_t process) { return StatusBytes(process, "VmRSS:"); }

std::int64_t PeakMemory(pid_t process) { return StatusBytes(process, "VmHWM:"); }

void ForgetPeak(pid_t process) { Write(fmt::format("/proc/{}/clear_refs", process), "5"); }

MemoryCgroup::MemoryCgroup(std::int64_t limit_bytes)
    : folder_(fmt::format("/sys/fs/cgroup/memory/motiondb-test-{}", getpid())) {
  std::error_code error;
  std::filesystem::create_directory(folder_, error);
  if (error || !std::filesystem::exists(folder_ + "/memory.limit_in_bytes")) {
    throw std::runtime_error("cannot create a memory cgroup (version 1): " + error.message());
  }
  Write(folder_ + "/memory.limit_in_bytes", std::to_string(limit_bytes));
}

MemoryCgroup::~MemoryCgroup() {
  std::error_code ignored;
  std::filesystem::remove(folder_, ignored);
}

void MemoryCgroup::Add(pid_t process) { Write(folder_ + "/cgroup.procs", std::to_string(process)); }

std::int64_t MemoryCgroup::peak() const {
  std::ifstream file(folder_ + "/memory.max_usage_in_bytes");
  std::int64_t bytes = 0;
  file >> bytes;
  return bytes;
}

}  // namespace motiondb::tests
