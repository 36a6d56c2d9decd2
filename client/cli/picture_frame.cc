#include "client/cli/picture_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "client/cli/svg.h"

namespace motiondb::client {
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
  // Counted, so that no error adds up.
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

}  // namespace motiondb::client
