// Texts of requests that are stored and end up in tables and on terminals: labels, names,
// descriptions. Safe to call from any thread.
#pragma once

#include <cstddef>
#include <string_view>

#include "absl/status/status.h"

namespace motiondb::server {

// INVALID_ARGUMENT for what looks like a bearer token: whatever is stored has many readers.
absl::Status CheckNoToken(std::string_view field, std::string_view text);

// INVALID_ARGUMENT for more bytes than `most`, a display control (core/format/text_encoding.h), or
// a token.
absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t most);

// The same for a text file of any length, which may have line ends and tabs.
absl::Status CheckPlainLines(std::string_view field, std::string_view text);

}  // namespace motiondb::server
