// Pieces of an SVG file: escaped text and numbers that are always written alike. Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::client {

// Text for an element or an attribute: characters that mean something to XML are escaped, those
// that XML does not allow are left out, and bytes that are not UTF-8 become '?'.
std::string SvgText(std::string_view text);

// A coordinate in pixels, with two decimals and never "-0.00"; 0 for what is not finite.
std::string SvgNumber(double value);

}  // namespace motiondb::client
