#include "tests/soak/process_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace motiondb::tests {
namespace {

namespace fs = std::filesystem;

double Megabytes(const std::string& file) {
  std::error_code gone;
  const auto bytes = fs::file_size(file, gone);
  return gone ? 0 : static_cast<double>(bytes) / 1e6;
}

}  // namespace

ProcessStatistics ReadProcessStatistics(pid_t process, const std::string& store) {
  const std::string folder = fmt::format("/proc/{}", process);
  std::ifstream status(folder + "/status");
  if (!status) throw std::runtime_error(fmt::format("process {} has ended", process));
  ProcessStatistics figures;
  std::string word;
  while (status >> word) {
    double kilobytes = 0;
    if (word == "VmRSS:" && status >> kilobytes) figures.memory_mb = kilobytes * 1024 / 1e6;
    if (word == "Threads:") status >> figures.threads;
  }
  figures.descriptors = static_cast<int>(
      std::distance(fs::directory_iterator(folder + "/fd"), fs::directory_iterator()));
  figures.store_mb = Megabytes(store);
  figures.log_mb = Megabytes(store + "-wal");
  return figures;
}

ProcessStatistics Largest(const ProcessStatistics& a, const ProcessStatistics& b) {
  return {std::max(a.memory_mb, b.memory_mb), std::max(a.descriptors, b.descriptors),
          std::max(a.threads, b.threads), std::max(a.store_mb, b.store_mb),
          std::max(a.log_mb, b.log_mb)};
}

}  // namespace motiondb::tests
