// Building blocks of the pictures of the command line: heading, legend, axes. Coordinates and sizes
// are pixels, y downwards.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "client/cli/plot/canvas.h"

namespace motiondb::client {

// Cuts a line of the heading to a width.
std::string TruncateToWidth(const std::string& text, double width);

// A title and lines below it, and their height with the gap below.
void DrawHeading(Canvas& canvas, double left, double width, const std::string& title,
                 const std::vector<std::string>& lines);
double HeadingHeight(std::size_t lines);

// A name, and a function that draws its sample at (x, y) and to the right of it.
struct LegendEntry {
  std::string name;
  std::function<void(Canvas& canvas, double x, double y)> sample;
};

// Entries side by side with a gap of `between`, in as many rows as necessary, the first at y.
// Returns the y of the last row.
double DrawLegend(Canvas& canvas, const std::vector<LegendEntry>& entries, double left,
                  double right, double y, double between = 22);

// A labelled position of an axis (pixels).
struct Tick {
  double at = 0;
  std::string text;
};

// Distance of ticks in units: 1, 2 or 5 times a power of ten, at least 80 pixels.
double TickStep(double pixels_per_unit);

// Multiples of `step` from `low` to `high`.
std::vector<double> Ticks(double low, double high, double step);

// Ticks with labels, with as many decimals as the step needs. `pixel` maps a value to its position.
std::vector<Tick> LinearTicks(double low, double high, double step,
                              const std::function<double(double)>& pixel);

// Lines through the frame at the ticks.
void DrawGrid(Canvas& canvas, const PictureFrame& frame, const std::vector<Tick>& x_ticks,
              const std::vector<Tick>& y_ticks);

// Labels below the line y = `bottom`, and left of the frame.
void DrawXTicks(Canvas& canvas, double bottom, const std::vector<Tick>& ticks);
void DrawYTicks(Canvas& canvas, const PictureFrame& frame, const std::vector<Tick>& ticks);

// Captions of the axes: below the labels, and at the left edge of the picture.
void DrawXCaption(Canvas& canvas, const PictureFrame& frame, double bottom, std::string_view text);
void DrawYCaption(Canvas& canvas, const PictureFrame& frame, std::string_view text);

// An axis for log probabilities of very different magnitude. The scale is an inverse hyperbolic
// sine: nearly linear down to about -10, logarithmic below.
class LogProbabilityAxis {
 public:
  // An axis without values, from 0 to -10.
  LogProbabilityAxis();

  // Extends the axis to a value, at most to kLowest; ignores values that are not finite.
  void Add(double value);

  // Returns the position of a value: 0 at the upper end, 1 at the lower end.
  double Fraction(double value) const;

  bool IsBelow(double value) const { return value < kLowest; }

  // Returns 0 and positive and negative powers of ten, from the top. Omits ticks that are closer
  // than `min_distance`, a fraction of the axis, to the tick before.
  std::vector<double> Ticks(double min_distance) const;

  // "0", "-10", "-10000", "-1e5".
  static std::string TickText(double value);

 private:
  static constexpr double kLowest = -1e6;

  double high_ = 0;
  double low_ = -10;
};

}  // namespace motiondb::client
