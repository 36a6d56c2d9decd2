// Texts of requests that end up in tables and on terminals: labels, names, descriptions. Safe to
// call from any thread.
#pragma once

#include <cstddef>
#include <string_view>

#include "absl/status/status.h"

namespace motiondb::server {

// INVALID_ARGUMENT for more bytes than `most`, or a control character.
absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t most);

}  // namespace motiondb::server
