// How a server is doing, on one screen for a person. Pure functions.
#pragma once

#include <motiondb/messages.h>

#include <cstdint>
#include <string>

namespace motiondb::client {

// `now_us`: the time it is now, in microseconds since the Unix epoch.
std::string StatusText(const v1::GetServerStatusResponse& status, std::int64_t now_us);

// In its two largest units: "12 s", "3 min 4 s", "5 h 0 min", "2 d 7 h".
std::string DurationText(std::int64_t seconds);

// Three figures in a unit that suits: "0.42 ms", "12.5 ms", "3.20 s", "75.0 s".
std::string LatencyText(double seconds);

// In the largest unit that leaves at least 1: "512 B", "1.5 MiB".
std::string BytesText(std::int64_t bytes);

}  // namespace motiondb::client
