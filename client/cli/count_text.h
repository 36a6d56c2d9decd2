// Counts in words for a person. Pure functions.
#pragma once

#include <cstdint>
#include <string>

namespace motiondb::client {

// "1 clip", "2 clips"; `noun` takes an s.
std::string CountText(std::int64_t count, const char* noun);

}  // namespace motiondb::client
