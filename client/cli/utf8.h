// Text as the wire contract carries it. Pure function.
#pragma once

#include <string_view>

namespace motiondb::client {

// True for well-formed UTF-8: a message with any other text would not arrive.
bool IsUtf8(std::string_view text);

}  // namespace motiondb::client
