// Values of HTTP headers (RFC 9110): lists, white space.
#pragma once

#include <string_view>

namespace motiondb::server {

// Returns the text without spaces and tabs around it.
std::string_view Trimmed(std::string_view text);

// Removes the first item of a list from it, with its separator, and returns it trimmed.
std::string_view TakeItem(std::string_view& list, char separator);

// Returns whether the value of Accept-Encoding contains gzip with a quality above 0.
bool AcceptsGzip(std::string_view list);

}  // namespace motiondb::server
