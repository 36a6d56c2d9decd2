// Pieces of an SVG file: escaped text, numbers that are always written alike, and elements, whose
// `style` is a class of the file's style sheet. Coordinates and sizes are pixels, y downwards. Pure
// functions.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::client {

// Text for an element or an attribute: characters that mean something to XML are escaped, those
// that XML does not allow are left out, and bytes that are not UTF-8 become '?'.
std::string SvgText(std::string_view text);

// A coordinate in pixels, with two decimals and never "-0.00"; 0 for what is not finite.
std::string SvgNumber(double value);

std::string SvgLine(std::string_view style, double x1, double y1, double x2, double y2);
std::string SvgCircle(std::string_view style, double x, double y, double radius);
std::string SvgRectangle(std::string_view style, double left, double top, double width,
                         double height);

// A line of text on a base line at y; `attributes` are written as they are.
std::string SvgLabel(std::string_view style, double x, double y, std::string_view text,
                     std::string_view attributes = "");

}  // namespace motiondb::client
