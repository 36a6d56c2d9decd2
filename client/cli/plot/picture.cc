#include "client/cli/plot/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "text/display_text.h"
#include "text/utf8.h"

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

namespace {

constexpr double kTitleHeight = 30, kLineHeight = 20, kBelowHeading = 18;
constexpr double kCharacterWidth = 6.6;  // average, of the lines below the title
constexpr double kLegendRowHeight = 22;
constexpr double kSampleWidth = 26;

constexpr const char* kStyle = R"(
    text { font-family: Helvetica, Arial, sans-serif; fill: #222; }
    .title { font-size: 18px; font-weight: bold; }
    .line { font-size: 13px; fill: #444; }
    .tick { font-size: 12px; fill: #555; }
    .grid { stroke: #e6e6e6; stroke-width: 1; }
    .frame { fill: none; stroke: #888; stroke-width: 1; })";

}  // namespace

std::string PictureHead(double width, double height, std::string_view title,
                        std::string_view style) {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\">\n"
      "<title>{2}</title>\n<style>{3}{4}</style>\n",
      SvgNumber(width), SvgNumber(height), SvgText(title), kStyle, style);
}

std::string BackgroundSvg(double width, double height) {
  return fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"#fff\"/>\n", SvgNumber(width),
                     SvgNumber(height));
}

std::string TruncateToWidth(const std::string& text, double width) {
  constexpr std::string_view kCut = "...";
  const auto max_size = static_cast<std::size_t>(std::max(0.0, width) / kCharacterWidth);
  if (text.size() <= max_size) return text;
  if (max_size <= kCut.size()) return "";
  return std::string(text::TruncateUtf8(text, max_size - kCut.size())).append(kCut);
}

std::string HeadingSvg(double left, double width, const std::string& title,
                       const std::vector<std::string>& lines) {
  double y = kTitleHeight;
  std::string svg = SvgLabel("title", left, y, TruncateToWidth(title, width));
  for (const std::string& line : lines) {
    y += kLineHeight;
    svg += SvgLabel("line", left, y, TruncateToWidth(line, width));
  }
  return svg;
}

double HeadingHeight(std::size_t lines) {
  return kTitleHeight + kBelowHeading + kLineHeight * static_cast<double>(lines);
}

Legend LegendSvg(const std::vector<LegendEntry>& entries, double left, double right, double y,
                 double between) {
  Legend legend{"", y};
  double x = left;
  for (const LegendEntry& entry : entries) {
    const double width =
        kSampleWidth + between + kCharacterWidth * static_cast<double>(entry.name.size());
    if (x + width > right && x > left) {
      x = left;
      legend.last_y += kLegendRowHeight;
    }
    legend.svg += entry.sample(x, legend.last_y) +
                  SvgLabel("line", x + kSampleWidth, legend.last_y + 4, entry.name);
    x += width;
  }
  return legend;
}

namespace {

constexpr double kPixelsBetweenTicks = 80;

}  // namespace

double TickStep(double pixels_per_unit) {
  const double wanted = kPixelsBetweenTicks / pixels_per_unit;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= wanted) return factor * power;
  }
  return 10 * power;
}

std::vector<double> Ticks(double low, double high, double step) {
  std::vector<double> ticks;
  // Multiplies instead of adding, to avoid rounding errors.
  const auto last = static_cast<long>(std::floor(high / step));
  for (auto i = static_cast<long>(std::ceil(low / step)); i <= last; ++i) {
    ticks.push_back(static_cast<double>(i) * step);
  }
  return ticks;
}

std::vector<Tick> LinearTicks(double low, double high, double step,
                              const std::function<double(double)>& pixel) {
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  std::vector<Tick> ticks;
  for (const double value : Ticks(low, high, step)) {
    ticks.push_back({pixel(value), fmt::format("{:.{}f}", value, decimals)});
  }
  return ticks;
}

std::string GridSvg(const PictureFrame& frame, const std::vector<Tick>& x_ticks,
                    const std::vector<Tick>& y_ticks) {
  std::string svg;
  for (const Tick& x : x_ticks) svg += SvgLine("grid", x.at, frame.top, x.at, frame.bottom());
  for (const Tick& y : y_ticks) svg += SvgLine("grid", frame.left, y.at, frame.right(), y.at);
  return svg;
}

std::string XTicksSvg(double bottom, const std::vector<Tick>& ticks) {
  std::string svg;
  for (const Tick& tick : ticks) {
    svg += SvgLabel("tick", tick.at, bottom + 17, tick.text, "text-anchor=\"middle\"");
  }
  return svg;
}

std::string YTicksSvg(const PictureFrame& frame, const std::vector<Tick>& ticks) {
  std::string svg;
  for (const Tick& tick : ticks) {
    svg += SvgLabel("tick", frame.left - 8, tick.at + 4, tick.text, "text-anchor=\"end\"");
  }
  return svg;
}

std::string XCaptionSvg(const PictureFrame& frame, double bottom, std::string_view text) {
  return SvgLabel("line", frame.left + frame.width / 2, bottom + 38, text,
                  "text-anchor=\"middle\"");
}

std::string YCaptionSvg(const PictureFrame& frame, std::string_view text) {
  const double middle = frame.top + frame.height / 2;
  return SvgLabel(
      "line", 20, middle, text,
      fmt::format("text-anchor=\"middle\" transform=\"rotate(-90 20.00 {})\"", SvgNumber(middle)));
}

std::string FrameSvg(const PictureFrame& frame) {
  return SvgRectangle("frame", frame.left, frame.top, frame.width, frame.height);
}

std::string ClipPathSvg(std::string_view id, const PictureFrame& frame) {
  return fmt::format(
      "<clipPath id=\"{}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n", id,
      SvgNumber(frame.left), SvgNumber(frame.top), SvgNumber(frame.width), SvgNumber(frame.height));
}

namespace {

constexpr double kLinear = 3;                   // the scale is logarithmic from about here
constexpr double kAbove = 0.05, kBelow = 0.04;  // margins, as a share of the axis

double Scaled(double value) { return std::asinh(value / kLinear); }

}  // namespace

LogProbabilityAxis::LogProbabilityAxis() = default;

void LogProbabilityAxis::Add(double value) {
  if (!std::isfinite(value)) return;
  low_ = std::min(low_, std::max(value, kLowest));
  high_ = std::max(high_, std::min(value, -kLowest));
}

double LogProbabilityAxis::Fraction(double value) const {
  const double span = (Scaled(high_) - Scaled(low_)) / (1 - kAbove - kBelow);
  return kAbove + (Scaled(high_) - Scaled(value)) / span;
}

std::vector<double> LogProbabilityAxis::Ticks(double min_distance) const {
  std::vector<double> below = {0}, above;
  const auto add = [&](std::vector<double>& ticks, double value) {
    const double last = ticks.empty() ? 0 : ticks.back();
    if (std::abs(Fraction(value) - Fraction(last)) >= min_distance) ticks.push_back(value);
  };
  for (double value = 1; - value >= low_; value *= 10) add(below, -value);
  for (double value = 1; value <= high_; value *= 10) add(above, value);
  above.insert(above.end(), below.begin(), below.end());
  std::sort(above.begin(), above.end(), std::greater<>());
  return above;
}

std::string LogProbabilityAxis::TickText(double value) {
  if (std::abs(value) < 1e5) return fmt::format("{:.0f}", value);
  return fmt::format("{}1e{:.0f}", value < 0 ? "-" : "", std::log10(std::abs(value)));
}

}  // namespace motiondb::client
