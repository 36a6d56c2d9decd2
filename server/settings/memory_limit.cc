#include "server/settings/memory_limit.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"

namespace motiondb::server {
namespace {

// What a file of a control group allows; `most` where it is not there or says "max".
std::int64_t LimitIn(const std::filesystem::path& file, std::int64_t most) {
  std::ifstream stream(file);
  std::string text;
  std::int64_t limit = 0;
  return stream >> text && absl::SimpleAtoi(text, &limit) ? std::min(limit, most) : most;
}

// Of the group and all above it, below `mount`. A container may see its group as the mount itself.
std::int64_t LimitOfGroup(const std::filesystem::path& mount, std::string group, const char* file,
                          std::int64_t most) {
  while (true) {
    most = LimitIn(mount / std::filesystem::path(group).relative_path() / file, most);
    if (group.empty()) return most;
    group.resize(group.find_last_of('/') == std::string::npos ? 0 : group.find_last_of('/'));
  }
}

}  // namespace

std::int64_t MemoryLimit(const std::string& root) {
  std::int64_t limit = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  // Lines of ID:CONTROLLERS:GROUP; version 2 has the id 0 and no controllers.
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::vector<std::string> parts = absl::StrSplit(line, absl::MaxSplits(':', 2));
    if (parts.size() != 3) continue;
    if (parts[1].empty()) {
      limit = LimitOfGroup(root + "/sys/fs/cgroup", parts[2], "memory.max", limit);
    } else if (parts[1] == "memory") {
      limit =
          LimitOfGroup(root + "/sys/fs/cgroup/memory", parts[2], "memory.limit_in_bytes", limit);
    }
  }
  return limit;
}

}  // namespace motiondb::server
