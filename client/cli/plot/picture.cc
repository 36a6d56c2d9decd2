#include "client/cli/plot/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "text/utf8.h"

namespace motiondb::client {

namespace {

constexpr double kTitleHeight = 30, kLineHeight = 20, kBelowHeading = 18;
constexpr double kCharacterWidth = 6.6;  // average, of the lines below the title
constexpr double kLegendRowHeight = 22;
constexpr double kSampleWidth = 26;

}  // namespace

std::string TruncateToWidth(const std::string& text, double width) {
  constexpr std::string_view kCut = "...";
  const auto max_size = static_cast<std::size_t>(std::max(0.0, width) / kCharacterWidth);
  if (text.size() <= max_size) return text;
  if (max_size <= kCut.size()) return "";
  return std::string(text::TruncateUtf8(text, max_size - kCut.size())).append(kCut);
}

void DrawHeading(Canvas& canvas, double left, double width, const std::string& title,
                 const std::vector<std::string>& lines) {
  double y = kTitleHeight;
  canvas.Label("title", left, y, TruncateToWidth(title, width));
  for (const std::string& line : lines) {
    y += kLineHeight;
    canvas.Label("line", left, y, TruncateToWidth(line, width));
  }
}

double HeadingHeight(std::size_t lines) {
  return kTitleHeight + kBelowHeading + kLineHeight * static_cast<double>(lines);
}

double DrawLegend(Canvas& canvas, const std::vector<LegendEntry>& entries, double left,
                  double right, double y, double between) {
  double x = left;
  for (const LegendEntry& entry : entries) {
    const double width =
        kSampleWidth + between + kCharacterWidth * static_cast<double>(entry.name.size());
    if (x + width > right && x > left) {
      x = left;
      y += kLegendRowHeight;
    }
    entry.sample(canvas, x, y);
    canvas.Label("line", x + kSampleWidth, y + 4, entry.name);
    x += width;
  }
  return y;
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

void DrawGrid(Canvas& canvas, const PictureFrame& frame, const std::vector<Tick>& x_ticks,
              const std::vector<Tick>& y_ticks) {
  for (const Tick& x : x_ticks) canvas.Line("grid", x.at, frame.top, x.at, frame.bottom());
  for (const Tick& y : y_ticks) canvas.Line("grid", frame.left, y.at, frame.right(), y.at);
}

void DrawXTicks(Canvas& canvas, double bottom, const std::vector<Tick>& ticks) {
  for (const Tick& tick : ticks) {
    canvas.Label("tick", tick.at, bottom + 17, tick.text, Anchor::kMiddle);
  }
}

void DrawYTicks(Canvas& canvas, const PictureFrame& frame, const std::vector<Tick>& ticks) {
  for (const Tick& tick : ticks) {
    canvas.Label("tick", frame.left - 8, tick.at + 4, tick.text, Anchor::kEnd);
  }
}

void DrawXCaption(Canvas& canvas, const PictureFrame& frame, double bottom, std::string_view text) {
  canvas.Label("line", frame.left + frame.width / 2, bottom + 38, text, Anchor::kMiddle);
}

void DrawYCaption(Canvas& canvas, const PictureFrame& frame, std::string_view text) {
  canvas.VerticalLabel("line", 20, frame.top + frame.height / 2, text);
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
