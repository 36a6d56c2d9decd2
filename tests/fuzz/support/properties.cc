#include "tests/fuzz/support/properties.h"

#include <cstdio>
#include <cstdlib>

namespace motiondb::tests {

void CheckContract(bool promise, std::string_view what) {
  if (promise) return;
  std::fprintf(stderr, "contract violated: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

void CheckErrorContract(const absl::Status& status, absl::StatusCode code) {
  if (status.ok()) return;
  if (status.code() != code) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  CheckContract(status.code() == code, "an error has a code of its reader's contract");
  CheckContract(!status.message().empty(), "an error has a message");
}

TwoFiles SplitAtZero(std::string_view input) {
  const std::size_t zero = input.find('\0');
  if (zero == std::string_view::npos) return {input, {}};
  return {input.substr(0, zero), input.substr(zero + 1)};
}

}  // namespace motiondb::tests
