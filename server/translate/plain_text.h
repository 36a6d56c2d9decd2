// Texts of requests that end up in tables and on terminals: labels, names, descriptions. Safe to
// call from any thread.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace motiondb::server {

// The text, which is valid UTF-8, with a U+FFFD for each control character: for what somebody sent
// who was refused, and another one reads.
std::string WithoutControls(std::string_view text);

// INVALID_ARGUMENT for more bytes than `most`, or a control character.
absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t most);

}  // namespace motiondb::server
