// How much memory this process may use, by the machine and by its control groups.
#pragma once

#include <cstdint>
#include <string>

namespace motiondb::server {

// In bytes: the least of the machine's memory and the limits of the process's control groups
// (versions 1 and 2) and those above them. `root` is where /proc and /sys are.
std::int64_t MemoryLimit(const std::string& root = "");

}  // namespace motiondb::server
