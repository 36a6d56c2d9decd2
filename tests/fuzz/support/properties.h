// The promises that every target checks. One that is broken ends the process, so that libFuzzer
// keeps the input. Stateless; for the one thread that libFuzzer calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "absl/status/status.h"

namespace motiondb::tests {

// Aborts, saying what was promised, unless it holds.
void Holds(bool promise, std::string_view what);

// An error has one of the codes that its reader promises, and says what was wrong.
void HoldsError(const absl::Status& status, absl::StatusCode code);

inline std::string_view AsText(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// "<first>\0<second>": how an input holds two files. Without a zero byte the second is empty.
struct TwoFiles {
  std::string_view first;
  std::string_view second;
};
TwoFiles SplitAtZero(std::string_view input);

}  // namespace motiondb::tests
