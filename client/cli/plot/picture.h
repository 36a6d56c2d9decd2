// Building blocks of the SVG pictures of the command line: elements, heading, legend, axes.
// Coordinates and sizes are pixels, y downwards. `style` is a class of the file's style sheet.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::client {

// Returns text for an element or attribute: XML characters are escaped, control characters and
// invalid UTF-8 are replaced by U+FFFD.
std::string SvgText(std::string_view text);

// Returns a coordinate with two decimals, never "-0.00"; 0 if it is not finite.
std::string SvgNumber(double value);

std::string SvgLine(std::string_view style, double x1, double y1, double x2, double y2);
std::string SvgCircle(std::string_view style, double x, double y, double radius);
std::string SvgRectangle(std::string_view style, double left, double top, double width,
                         double height);

// A line of text with its base line at y; `attributes` are not escaped.
std::string SvgLabel(std::string_view style, double x, double y, std::string_view text,
                     std::string_view attributes = "");

// Opens an SVG file. `style` is added to the shared styles title, line, tick, grid and frame. The
// caller ends the file with "</svg>\n".
std::string PictureHead(double width, double height, std::string_view title,
                        std::string_view style);

std::string BackgroundSvg(double width, double height);

// Cuts a line of the heading to a width.
std::string TruncateToWidth(const std::string& text, double width);

// A title and lines below it, and their height with the gap below.
std::string HeadingSvg(double left, double width, const std::string& title,
                       const std::vector<std::string>& lines);
double HeadingHeight(std::size_t lines);

// A name, and a function that draws its sample at (x, y) and to the right of it.
struct LegendEntry {
  std::string name;
  std::function<std::string(double x, double y)> sample;
};

struct Legend {
  std::string svg;
  double last_y = 0;  // y of the last row
};

// Entries side by side with a gap of `between`, in as many rows as necessary, the first at y.
Legend LegendSvg(const std::vector<LegendEntry>& entries, double left, double right, double y,
                 double between = 22);

// The rectangle of a picture that shows data.
struct PictureFrame {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
};

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
std::string GridSvg(const PictureFrame& frame, const std::vector<Tick>& x_ticks,
                    const std::vector<Tick>& y_ticks);

// Labels below the line y = `bottom`, and left of the frame.
std::string XTicksSvg(double bottom, const std::vector<Tick>& ticks);
std::string YTicksSvg(const PictureFrame& frame, const std::vector<Tick>& ticks);

// Captions of the axes: below the labels, and at the left edge of the picture.
std::string XCaptionSvg(const PictureFrame& frame, double bottom, std::string_view text);
std::string YCaptionSvg(const PictureFrame& frame, std::string_view text);

std::string FrameSvg(const PictureFrame& frame);

// Defines the inside of the frame as the clip path `id`.
std::string ClipPathSvg(std::string_view id, const PictureFrame& frame);

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
