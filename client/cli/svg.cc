#include "client/cli/svg.h"

#include <fmt/format.h>

#include <cmath>

#include "text/display_text.h"

namespace motiondb::client {

std::string SvgText(std::string_view text) {
  std::string escaped;
  for (const char c : text::DisplayLines(text)) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else {
      escaped += c == '\n' ? ' ' : c;
    }
  }
  return escaped;
}

std::string SvgNumber(double value) {
  const bool nothing = !std::isfinite(value) || std::abs(value) < 0.005;
  return fmt::format("{:.2f}", nothing ? 0.0 : value);
}

std::string SvgLine(std::string_view style, double x1, double y1, double x2, double y2) {
  return fmt::format("<line class=\"{}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n", style,
                     SvgNumber(x1), SvgNumber(y1), SvgNumber(x2), SvgNumber(y2));
}

std::string SvgCircle(std::string_view style, double x, double y, double radius) {
  return fmt::format("<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", style, SvgNumber(x),
                     SvgNumber(y), SvgNumber(radius));
}

std::string SvgRectangle(std::string_view style, double left, double top, double width,
                         double height) {
  return fmt::format("<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n", style,
                     SvgNumber(left), SvgNumber(top), SvgNumber(width), SvgNumber(height));
}

std::string SvgLabel(std::string_view style, double x, double y, std::string_view text,
                     std::string_view attributes) {
  return fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\"{}{}>{}</text>\n", style, SvgNumber(x),
                     SvgNumber(y), attributes.empty() ? "" : " ", attributes, SvgText(text));
}

}  // namespace motiondb::client
