// Checks of contracts. A violation aborts the process, so that libFuzzer keeps the input. For
// libFuzzer's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "absl/status/status.h"

namespace motiondb::tests {

// Aborts with the text `what` if `promise` is false.
void CheckContract(bool promise, std::string_view what);

// Checks that an error has this code and a message.
void CheckErrorContract(const absl::Status& status, absl::StatusCode code);

inline std::string_view AsText(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// "<first>\0<second>": an input with two files. Without a zero byte the second is empty.
struct TwoFiles {
  std::string_view first;
  std::string_view second;
};
TwoFiles SplitAtZero(std::string_view input);

}  // namespace motiondb::tests
