// Names and messages may hold bytes from motion files, which need not be UTF-8; protobuf strings
// must be. Safe to call from any thread.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace motiondb::server {

// The text with every byte that is not part of valid UTF-8 replaced by U+FFFD.
std::string ValidUtf8(std::string_view text);

// The same, cut to at most `limit` bytes between characters, with "..." where something was cut.
std::string ValidUtf8(std::string_view text, std::size_t limit);

}  // namespace motiondb::server
