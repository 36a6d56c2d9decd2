// Text that leaves the server to be read by people: errors, the log, the audit log. Safe to call
// from any thread.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::server {

// One line of valid UTF-8: tokens without their secrets (secret.h), and U+FFFD for each display
// control (core/format/text_encoding.h) and each byte that is not UTF-8.
std::string ShownText(std::string_view text);

}  // namespace motiondb::server
